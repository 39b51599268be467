// The part of zenoh-c's API (1.x) that examples/external_vehicle/vehicle.cpp uses, written anew:
// `make external-cpp` builds against a package that has the library but not its headers. Everything
// is passed by address, so that types may be larger here than in the library.
#pragma once
#include <stddef.h>
#include <stdint.h>

#define ZENOH_TYPE(name)                                            \
    struct z_owned_##name##_t { alignas(16) unsigned char _[8192]; }; \
    struct z_loaned_##name##_t;                                     \
    typedef z_owned_##name##_t z_moved_##name##_t;                  \
    static inline z_moved_##name##_t *z_move(z_owned_##name##_t &x) { return &x; }
#define ZENOH_LOAN(name)                                                                \
    extern "C" const z_loaned_##name##_t *z_##name##_loan(const z_owned_##name##_t *);   \
    static inline const z_loaned_##name##_t *z_loan(const z_owned_##name##_t &x) {       \
        return z_##name##_loan(&x);                                                      \
    }
#define ZENOH_DROP(name)                                 \
    extern "C" void z_##name##_drop(z_moved_##name##_t *); \
    static inline void z_drop(z_moved_##name##_t *x) { z_##name##_drop(x); }

typedef int8_t z_result_t;
enum { Z_OK = 0 };
typedef enum { Z_SAMPLE_KIND_PUT = 0, Z_SAMPLE_KIND_DELETE = 1 } z_sample_kind_t;
struct z_matching_status_t { bool matching; };
ZENOH_TYPE(config) ZENOH_TYPE(session) ZENOH_TYPE(bytes) ZENOH_TYPE(slice) ZENOH_TYPE(sample)
ZENOH_TYPE(reply) ZENOH_TYPE(publisher) ZENOH_TYPE(subscriber) ZENOH_TYPE(liveliness_token)
ZENOH_TYPE(closure_sample) ZENOH_TYPE(closure_reply)
ZENOH_TYPE(fifo_handler_sample) ZENOH_TYPE(fifo_handler_reply)
ZENOH_LOAN(session) ZENOH_LOAN(slice) ZENOH_LOAN(sample) ZENOH_LOAN(reply) ZENOH_LOAN(publisher)
ZENOH_LOAN(fifo_handler_sample) ZENOH_LOAN(fifo_handler_reply)
ZENOH_DROP(slice) ZENOH_DROP(sample)
struct z_view_keyexpr_t { alignas(16) unsigned char _[256]; };
struct z_loaned_keyexpr_t;

extern "C" {
const z_loaned_keyexpr_t *z_view_keyexpr_loan(const z_view_keyexpr_t *);
z_result_t z_view_keyexpr_from_str(z_view_keyexpr_t *, const char *);
z_result_t zc_config_from_str(z_owned_config_t *, const char *);
z_result_t z_open(z_owned_session_t *, z_moved_config_t *, const void *);
z_result_t z_bytes_to_slice(const z_loaned_bytes_t *, z_owned_slice_t *);
z_result_t z_bytes_copy_from_buf(z_owned_bytes_t *, const uint8_t *, size_t);
const uint8_t *z_slice_data(const z_loaned_slice_t *);
size_t z_slice_len(const z_loaned_slice_t *);
const z_loaned_bytes_t *z_sample_payload(const z_loaned_sample_t *);
z_sample_kind_t z_sample_kind(const z_loaned_sample_t *);
const z_loaned_sample_t *z_reply_ok(const z_loaned_reply_t *);
void z_fifo_channel_reply_new(z_owned_closure_reply_t *, z_owned_fifo_handler_reply_t *, size_t);
void z_fifo_channel_sample_new(z_owned_closure_sample_t *, z_owned_fifo_handler_sample_t *, size_t);
z_result_t z_fifo_handler_reply_recv(const z_loaned_fifo_handler_reply_t *, z_owned_reply_t *);
z_result_t z_fifo_handler_sample_recv(const z_loaned_fifo_handler_sample_t *, z_owned_sample_t *);
z_result_t z_get(const z_loaned_session_t *, const z_loaned_keyexpr_t *, const char *,
                 z_moved_closure_reply_t *, void *);
void z_closure_sample(z_owned_closure_sample_t *, void (*)(z_loaned_sample_t *, void *),
                      void (*)(void *), void *);
z_result_t z_declare_subscriber(const z_loaned_session_t *, z_owned_subscriber_t *,
                                const z_loaned_keyexpr_t *, z_moved_closure_sample_t *, void *);
z_result_t z_declare_publisher(const z_loaned_session_t *, z_owned_publisher_t *,
                               const z_loaned_keyexpr_t *, const void *);
z_result_t z_publisher_put(const z_loaned_publisher_t *, z_moved_bytes_t *, void *);
z_result_t z_publisher_get_matching_status(const z_loaned_publisher_t *, z_matching_status_t *);
z_result_t z_liveliness_declare_subscriber(const z_loaned_session_t *, z_owned_subscriber_t *,
                                           const z_loaned_keyexpr_t *, z_moved_closure_sample_t *,
                                           void *);
z_result_t z_liveliness_declare_token(const z_loaned_session_t *, z_owned_liveliness_token_t *,
                                      const z_loaned_keyexpr_t *, const void *);
}
static inline const z_loaned_keyexpr_t *z_loan(const z_view_keyexpr_t &x) {
    return z_view_keyexpr_loan(&x);
}
static inline void z_closure(z_owned_closure_sample_t *x, void (*call)(z_loaned_sample_t *, void *),
                             void (*drop)(void *), void *context) {
    z_closure_sample(x, call, drop, context);
}
static inline z_result_t z_recv(const z_loaned_fifo_handler_reply_t *h, z_owned_reply_t *x) {
    return z_fifo_handler_reply_recv(h, x);
}
static inline z_result_t z_recv(const z_loaned_fifo_handler_sample_t *h, z_owned_sample_t *x) {
    return z_fifo_handler_sample_recv(h, x);
}
