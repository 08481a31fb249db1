// Binary messages in the daemon's format.

function header(stream, { first = 0, t0 = 0, dt = 0, n, channels = 0, flags = 0 }) {
    const head = Buffer.alloc(40);
    head.writeUInt32LE(0x534b4431, 0);
    head.writeUInt16LE(1, 4);
    head.writeUInt16LE(stream, 6);
    head.writeBigUInt64LE(BigInt(first), 8);
    head.writeDoubleLE(t0, 16);
    head.writeDoubleLE(dt, 24);
    head.writeUInt32LE(n, 32);
    head.writeUInt16LE(channels, 36);
    head.writeUInt16LE(flags, 38);
    return head;
}

/** `columns`: a list of numbers for each channel. */
export function samples(stream, columns, { first, t0, dt, flags }) {
    const n = columns[0].length, channels = columns.length;
    const body = Buffer.alloc(4 * n * channels);
    for (let i = 0; i < n; i++) columns.forEach((column, c) => body.writeFloatLE(column[i], 4 * (i * channels + c)));
    return [header(stream, { first, t0, dt, n, channels, flags }), body];
}

/** `marks`: [{x, y, width, height, kind}]. */
export function picture(camera, jpeg, width, height, marks, { first, t0, flags }) {
    const body = Buffer.alloc(8 + 16 * marks.length + Math.ceil(marks.length / 4) * 4);
    body.writeUInt16LE(width, 0);
    body.writeUInt16LE(height, 2);
    body.writeUInt16LE(marks.length, 4);
    marks.forEach((mark, i) => {
        [mark.x, mark.y, mark.width, mark.height].forEach((value, k) => body.writeFloatLE(value, 8 + 16 * i + 4 * k));
        body.writeUInt8(mark.kind, 8 + 16 * marks.length + i);
    });
    return [header(16 + camera, { first, t0, n: jpeg.length, flags }), body, jpeg];
}
