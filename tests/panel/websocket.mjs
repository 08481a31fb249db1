// A WebSocket server (RFC 6455) with the functions that the page needs: text in, text and binary out, no extensions.
import { createHash } from "node:crypto";

const key = "258EAFA5-E914-47DA-95CA-C5AB0DC85B11";

function frame(opcode, payload) {
    const size = payload.length;
    const head = size < 126 ? Buffer.alloc(2) : size < 65536 ? Buffer.alloc(4) : Buffer.alloc(10);
    head[0] = 0x80 | opcode;
    if (size < 126) head[1] = size;
    else if (size < 65536) {
        head[1] = 126;
        head.writeUInt16BE(size, 2);
    } else {
        head[1] = 127;
        head.writeBigUInt64BE(BigInt(size), 2);
    }
    return Buffer.concat([head, payload]);
}

/** The first complete frame of a client: {opcode, payload, used}; null when more bytes are needed. */
function parse(data) {
    if (data.length < 6) return null;
    let size = data[1] & 0x7f, at = 2;
    if (size === 126) {
        size = data.readUInt16BE(2);
        at = 4;
    }
    if (data.length < at + 4 + size) return null;
    const mask = data.subarray(at, at + 4);
    const payload = Buffer.from(data.subarray(at + 4, at + 4 + size));
    for (let i = 0; i < size; i++) payload[i] ^= mask[i % 4];
    return { opcode: data[0] & 15, payload, used: at + 4 + size };
}

/** Answers the upgrade; returns {text, binary, drop, backlog} and calls onText and onEnd. */
export function accept(request, socket, onText, onEnd) {
    const answer = createHash("sha1").update(request.headers["sec-websocket-key"] + key).digest("base64");
    socket.write("HTTP/1.1 101 Switching Protocols\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n" +
        `Sec-WebSocket-Accept: ${answer}\r\n\r\n`);
    socket.setNoDelay(true);
    let pending = Buffer.alloc(0);
    socket.on("data", (chunk) => {
        pending = Buffer.concat([pending, chunk]);
        for (let one = parse(pending); one; one = parse(pending)) {
            pending = pending.subarray(one.used);
            if (one.opcode === 1) onText(one.payload.toString("utf8"));
            if (one.opcode === 8) socket.end(frame(8, one.payload));
        }
    });
    socket.on("error", () => socket.destroy());
    socket.on("close", onEnd);
    return {
        text: (value) => socket.write(frame(1, Buffer.from(JSON.stringify(value)))),
        binary: (buffers) => socket.write(frame(2, Buffer.concat(buffers))),
        drop: () => socket.destroy(),
        backlog: () => socket.writableLength,
    };
}
