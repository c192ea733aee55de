// Reads an MCAP file as Foxglove does and prints, as JSON, every message of every topic, decoded.
// node read.mjs FILE.mcap
import { open } from "node:fs/promises";
import { parse } from "@foxglove/rosmsg";
import { MessageReader } from "@foxglove/rosmsg2-serialization";
import { McapIndexedReader } from "@mcap/core";
import { loadDecompressHandlers } from "@mcap/support";

const file = await open(process.argv[2], "r");
const readable = {
  size: async () => BigInt((await file.stat()).size),
  read: async (offset, size) => {
    const bytes = new Uint8Array(Number(size));
    const { bytesRead } = await file.read(bytes, 0, bytes.length, Number(offset));
    if (bytesRead !== bytes.length) throw new Error(`read ${bytesRead} of ${bytes.length} bytes`);
    return bytes;
  },
};

const decompressHandlers = await loadDecompressHandlers();
const bag = await McapIndexedReader.Initialize({ readable, decompressHandlers });
const readers = new Map();
for (const channel of bag.channelsById.values()) {
  const schema = bag.schemasById.get(channel.schemaId);
  if (schema.encoding !== "ros2msg" || channel.messageEncoding !== "cdr") {
    throw new Error(`${channel.topic}: ${schema.encoding}, ${channel.messageEncoding}`);
  }
  const definitions = parse(new TextDecoder().decode(schema.data), { ros2: true });
  readers.set(channel.id, new MessageReader(definitions));
}

const topics = {};
let last = 0n;
for await (const message of bag.readMessages()) {
  if (message.logTime < last) throw new Error("log time runs backwards");
  last = message.logTime;
  const channel = bag.channelsById.get(message.channelId);
  const topic = (topics[channel.topic] ??= {
    type: bag.schemasById.get(channel.schemaId).name,
    messages: [],
  });
  topic.messages.push(readers.get(message.channelId).readMessage(message.data));
}
const plain = (_, value) =>
  typeof value === "bigint" ? Number(value) : ArrayBuffer.isView(value) ? Array.from(value) : value;
process.stdout.write(
  JSON.stringify({ profile: bag.header.profile, counted: Number(bag.statistics.messageCount), topics }, plain),
);
