// A vehicle in C++: FM by its own radar, in real time; it sends beacons, but reads none.
#include <google/protobuf/text_format.h>
#include <unistd.h>
#include <zenoh.h>
#include <chrono>
#include <fstream>
#include <nlohmann/json.hpp>
#include "messages.pb.h"

using nlohmann::json, std::string;

#define NOTHING \
    "{gap: nan speed: nan gap_std: nan speed_std: nan predicted_gap: nan predicted_speed: nan}"
const char *const UNKNOWN =  // it estimates nothing
    "ahead " NOTHING "behind " NOTHING "speed: nan speed_std: nan predicted_speed: nan age_ns: -1";

static string content(const z_loaned_sample_t *sample) {
    z_owned_slice_t slice;
    z_bytes_to_slice(z_sample_payload(sample), &slice);
    string copy((const char *)z_slice_data(z_loan(slice)), z_slice_len(z_loan(slice)));
    return z_drop(z_move(slice)), copy;
}

static void put(const z_owned_publisher_t &publisher, const string &payload) {
    z_owned_bytes_t bytes;
    z_bytes_copy_from_buf(&bytes, (const uint8_t *)payload.data(), payload.size());
    z_publisher_put(z_loan(publisher), z_move(bytes), NULL);
}

static double follow(const zenvoy::Sense &sense, const json &c) {  // acceleration, m/s²
    double limit = c["acceleration_limit_mps2"], p_des = c["desired_gap_m"];
    double a = c["gains"]["k_d"].get<double>() * (sense.ahead().gap() - p_des) +
               c["gains"]["k_v"].get<double>() * sense.ahead().speed() +
               c["gains"]["k_c"].get<double>() * (double(c["desired_speed_mps"]) - sense.speed());
    return std::clamp(a, -limit, limit);
}

static void on_world(z_loaned_sample_t *sample, void *) {
    if (z_sample_kind(sample) == Z_SAMPLE_KIND_DELETE) _exit(0);
}

int main(int, char **argv) {
    json met = json::parse(std::ifstream(argv[2])), settings, scenario;
    string run = "zenvoy/" + met["run"].get<string>(), own = run + "/vehicle/" + argv[1], text;
    settings["connect"]["endpoints"] = {met["world"][0], met["channel"][0]};
    settings["listen"]["endpoints"] = json::array();
    for (auto how : {"multicast", "gossip"}) settings["scouting"][how]["enabled"] = false;
    z_owned_config_t config;  // types that own, loans and moves: see the manual of zenoh-c
    z_owned_session_t session;
    zc_config_from_str(&config, settings.dump().c_str());
    if (z_open(&session, z_move(config), NULL)) return 1;
    const z_loaned_session_t *zenoh = z_loan(session);
    z_view_keyexpr_t key;
    auto at = [&](const string &name) {
        return z_view_keyexpr_from_str(&key, (text = name).c_str()), z_loan(key);
    };
    for (; scenario.is_null(); usleep(10'000)) {  // until the world answers
        z_owned_fifo_handler_reply_t replies;
        z_owned_closure_reply_t asked;
        z_fifo_channel_reply_new(&asked, &replies, 1);
        z_get(zenoh, at(run + "/scenario"), "", z_move(asked), NULL);
        if (z_owned_reply_t reply; z_recv(z_loan(replies), &reply) == Z_OK)
            scenario = json::parse(content(z_reply_ok(z_loan(reply))));
    }
    auto of = [&](const char *path) { return scenario[json::json_pointer(path)].get<double>(); };
    z_owned_closure_sample_t to_sense, to_end;
    z_owned_fifo_handler_sample_t senses;
    z_owned_subscriber_t sensor, watcher;
    z_owned_publisher_t beacons, commands;
    z_fifo_channel_sample_new(&to_sense, &senses, 256);
    z_closure(&to_end, on_world, NULL, NULL);
    z_declare_subscriber(zenoh, &sensor, at(own + "/sense"), z_move(to_sense), NULL);
    z_liveliness_declare_subscriber(zenoh, &watcher, at(run + "/alive/world"), z_move(to_end), NULL);
    z_declare_publisher(zenoh, &beacons, at(own + "/beacon"), NULL);
    z_declare_publisher(zenoh, &commands, at(own + "/command"), NULL);
    for (auto *publisher : {&beacons, &commands})  // earlier messages would be lost
        for (z_matching_status_t read = {false}; !read.matching; usleep(1'000))
            z_publisher_get_matching_status(z_loan(*publisher), &read);
    string size = std::to_string(int(of("/fleet/size"))), name = argv[1];
    while (name.size() < std::max<size_t>(2, size.size())) name = "0" + name;
    z_owned_liveliness_token_t ready;
    z_liveliness_declare_token(zenoh, &ready, at(run + "/alive/vehicle-" + name), NULL);

    z_owned_sample_t sample;
    for (; z_recv(z_loan(senses), &sample) == Z_OK; z_drop(z_move(sample))) {
        zenvoy::Sense sense;
        zenvoy::Beacon beacon;
        sense.ParseFromString(content(z_loan(sample)));
        auto wall_ns = std::chrono::steady_clock::now().time_since_epoch().count();
        int64_t now_ns = (wall_ns - sense.wall_start_ns()) * of("/speed");
        if (now_ns - sense.time_ns() > of("/period_ms") * 1e6) continue;  // this process was stopped
        // The rest of a sense has the same names in a beacon.
        sense.clear_wall_start_ns(), google::protobuf::TextFormat::PrintToString(sense, &text);
        google::protobuf::TextFormat::ParseFromString(text, &beacon);
        beacon.set_sequence(sense.cycle()), beacon.add_planned_from_ns(sense.time_ns());
        beacon.add_planned_acceleration(sense.acceleration());
        put(beacons, beacon.SerializeAsString());
        zenvoy::Command command;
        google::protobuf::TextFormat::ParseFromString(UNKNOWN, &command);
        command.set_cycle(sense.cycle()), command.set_vehicle(sense.vehicle());
        command.set_time_ns(sense.time_ns() + int64_t(of("/control/v2v_wait_ms") * 1e6));
        command.set_effective_ns(command.time_ns() + int64_t(of("/control/system_delay_ms") * 1e6));
        auto &timing = *command.mutable_timing();  // it uses no frames
        timing.set_sensed_ns(now_ns), timing.set_decided_ns(now_ns);
        command.set_mode(sense.has_ahead() ? zenvoy::MODE_FM : zenvoy::MODE_CONSTANT_SPEED);
        if (sense.has_ahead()) command.set_acceleration(follow(sense, scenario["control"]));
        usleep(std::max(0.0, (command.time_ns() - now_ns) / of("/speed") * 1e-3));
        put(commands, command.SerializeAsString());
    }
}
