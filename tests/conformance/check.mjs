// Reads a log of Zenvoy with the MCAP and protobuf libraries of another language, and uses only
// what the file says about itself: node check.mjs <file.mcap>
//
// It makes two passes, through the index and from end to end, checks every CRC, and decodes every
// message by its embedded schema. On the first fault it prints one line and exits with 1.
import { createReadStream } from "node:fs";
import { open } from "node:fs/promises";
import { crc32 } from "node:zlib";

import { McapIndexedReader, McapStreamReader } from "@mcap/core";
import { loadDecompressHandlers, protobufFromBinaryDescriptor } from "@mcap/support";

const METADATA = ["zenvoy.run"];
const ATTACHMENTS = ["scenario.yaml", "effective.json"];
const TRUTH = { topic: "/fleet/truth", columns: ["position", "speed", "acceleration"] };

class Failure extends Error {}

function check(condition, message) {
  if (!condition) throw new Failure(message);
}

function readableOf(handle) {
  return {
    size: async () => BigInt((await handle.stat()).size),
    read: async (offset, length) => {
      const bytes = new Uint8Array(Number(length));
      const { bytesRead } = await handle.read(bytes, 0, bytes.length, Number(offset));
      check(bytesRead === bytes.length, `the file ends within ${length} bytes at ${offset}`);
      return bytes;
    },
  };
}

/** The decoders of all channels, by channel id, built from the schemas in the file. */
function decodersOf(reader) {
  const decoders = new Map();
  for (const channel of reader.channelsById.values()) {
    const schema = reader.schemasById.get(channel.schemaId);
    check(schema, `${channel.topic}: no schema`);
    check(schema.encoding === "protobuf", `${channel.topic}: schema encoding ${schema.encoding}`);
    check(
      channel.messageEncoding === "protobuf",
      `${channel.topic}: message encoding ${channel.messageEncoding}`,
    );
    // a set that lacks an imported file fails here, as its types do not resolve
    decoders.set(channel.id, protobufFromBinaryDescriptor(schema.data).lookupType(schema.name));
  }
  return decoders;
}

function checkMessage(where, message, type) {
  check(message.logTime !== 0n, `${where}: log_time is 0`);
  check(
    message.logTime === message.publishTime,
    `${where}: log_time ${message.logTime}, publish_time ${message.publishTime}`,
  );
  const value = type.decode(message.data);
  // protobuf skips unknown fields: only a schema that knows all bytes reproduces all of them
  const length = type.encode(value).finish().length;
  check(
    length === message.data.length,
    `${where}: the schema explains ${length} of ${message.data.length} bytes`,
  );
  return value;
}

function checkTruth(where, value) {
  const lengths = TRUTH.columns.map((column) => {
    check(Array.isArray(value[column]), `${where}: ${column} is not an array`);
    return value[column].length;
  });
  check(lengths[0] > 0, `${where}: no vehicle`);
  check(
    lengths.every((length) => length === lengths[0]),
    `${where}: lengths of ${TRUTH.columns.join(", ")}: ${lengths.join(", ")}`,
  );
}

/** Messages by channel id, read through the index. */
async function readIndexed(reader) {
  const decoders = decodersOf(reader);
  const counts = new Map([...reader.channelsById.keys()].map((id) => [id, 0n]));
  for await (const message of reader.readMessages({ validateCrcs: true })) {
    const { topic } = reader.channelsById.get(message.channelId);
    const where = `${topic}, message ${counts.get(message.channelId)}`;
    const value = checkMessage(where, message, decoders.get(message.channelId));
    if (topic === TRUTH.topic) checkTruth(where, value);
    counts.set(message.channelId, counts.get(message.channelId) + 1n);
  }
  return counts;
}

/** Messages by channel id, read from end to end. */
async function readStream(path, decompressHandlers) {
  const reader = new McapStreamReader({
    decompressHandlers,
    includeChunks: true,
    validateCrcs: true,
  });
  const counts = new Map();
  for await (const bytes of createReadStream(path)) {
    reader.append(bytes);
    for (let record; (record = reader.nextRecord()); ) {
      // a CRC of 0 means "none", and the libraries then check nothing
      if (record.type === "Chunk") check(record.uncompressedCrc !== 0, "a chunk has no CRC");
      if (record.type !== "Message") continue;
      counts.set(record.channelId, (counts.get(record.channelId) ?? 0n) + 1n);
    }
  }
  check(reader.done(), "the file ends without a footer");
  return counts;
}

async function checkDataSection(path, reader) {
  if (reader.dataSectionCrc === undefined) return "none";
  let crc = 0;
  const end = Number(reader.dataEndOffset) - 1;
  for await (const bytes of createReadStream(path, { end })) crc = crc32(bytes, crc);
  check(crc === reader.dataSectionCrc, `data section CRC ${crc}, not ${reader.dataSectionCrc}`);
  return "good";
}

function checkCounts(reader, indexed, streamed) {
  const { statistics } = reader;
  check(statistics, "no statistics record");
  let total = 0n;
  for (const [id, count] of indexed) {
    const { topic } = reader.channelsById.get(id);
    const stated = statistics.channelMessageCounts.get(id) ?? 0n;
    check(count === stated, `${topic}: ${count} messages in the index, statistics say ${stated}`);
    const inStream = streamed.get(id) ?? 0n;
    check(inStream === stated, `${topic}: ${inStream} messages in all, statistics say ${stated}`);
    total += count;
  }
  const stated = statistics.messageCount;
  check(total > 0n, "no messages");
  check(total === stated, `${total} messages, statistics say ${stated}`);
  check(statistics.channelCount === indexed.size, "statistics: wrong number of channels");
  check(statistics.chunkCount === reader.chunkIndexes.length, "statistics: wrong number of chunks");
}

function checkJson({ name, data }) {
  try {
    JSON.parse(new TextDecoder("utf-8", { fatal: true }).decode(data));
  } catch (error) {
    throw new Failure(`attachment ${name}: ${error.message}`);
  }
}

async function checkExtras(reader) {
  const metadata = [];
  for await (const record of reader.readMetadata()) metadata.push(record.name);
  const attachments = [];
  for await (const record of reader.readAttachments({ validateCrcs: true })) {
    check(record.data.length > 0, `attachment ${record.name} is empty`);
    if (record.name.endsWith(".json")) checkJson(record);
    attachments.push(record.name);
  }
  for (const name of METADATA) check(metadata.includes(name), `no metadata ${name}`);
  for (const name of ATTACHMENTS) check(attachments.includes(name), `no attachment ${name}`);
  const { metadataCount, attachmentCount } = reader.statistics;
  check(metadataCount === metadata.length, "statistics: wrong number of metadata records");
  check(attachmentCount === attachments.length, "statistics: wrong number of attachments");
  return { metadata, attachments };
}

function printTable(reader, counts) {
  const rows = [["topic", "schema", "count"]];
  for (const [id, count] of counts) {
    const { topic, schemaId } = reader.channelsById.get(id);
    rows.push([topic, reader.schemasById.get(schemaId).name, String(count)]);
  }
  const widths = [0, 1, 2].map((i) => Math.max(...rows.map((row) => row[i].length)));
  for (const [topic, schema, count] of rows) {
    console.log(
      `${topic.padEnd(widths[0])}  ${schema.padEnd(widths[1])}  ${count.padStart(widths[2])}`,
    );
  }
}

async function checkFile(path) {
  const decompressHandlers = await loadDecompressHandlers();
  const handle = await open(path);
  try {
    const readable = readableOf(handle);
    const reader = await McapIndexedReader.Initialize({ readable, decompressHandlers });
    check(reader.footer.summaryCrc !== 0, "the summary has no CRC");
    check(reader.header.profile === "", `profile is ${reader.header.profile}, not empty`);
    const indexed = await readIndexed(reader);
    const streamed = await readStream(path, decompressHandlers);
    checkCounts(reader, indexed, streamed);
    const topics = [...reader.channelsById.values()].map((channel) => channel.topic);
    check(topics.includes(TRUTH.topic), `no topic ${TRUTH.topic}`);
    const { metadata, attachments } = await checkExtras(reader);
    const dataSection = await checkDataSection(path, reader);
    printTable(reader, indexed);
    console.log(`metadata: ${metadata.join(", ")}; attachments: ${attachments.join(", ")}`);
    const chunks = reader.chunkIndexes.length;
    console.log(`CRC: ${chunks} chunks and the summary good, data section ${dataSection}`);
  } finally {
    await handle.close();
  }
}

const [path, ...rest] = process.argv.slice(2);
if (path === undefined || rest.length > 0) {
  console.error("usage: node check.mjs <file.mcap>");
  process.exit(2);
}
try {
  await checkFile(path);
} catch (error) {
  console.error(`FAILED: ${path}: ${String(error.message).split("\n", 1)[0]}`);
  process.exit(1);
}
