// Binary messages: a header of 40 bytes, then samples or one picture, all little-endian.

const magic = 0x534b4431;
const version = 1;
const headerBytes = 40;
const markBytes = 17;  // four f32 and a kind
const firstCamera = 16;

export const streamIds = { acceleration: 1, waveform: 2, cycle: 3, track: 4 } as const;

export interface SampleFrame {
    what: "samples";
    stream: number;
    first: number;
    t0: number;        // s
    dt: number;        // s between points
    count: number;     // points
    channels: number;
    gap: boolean;      // samples are missing before the first point
    pairs: boolean;    // points alternate between least and greatest value
    decimated: boolean;
    values: Float32Array;  // all channels of the first point, then of the second, ...
}

/**
 * In px of the picture; x, y is the upper left corner. Lower 4 bits of `kind`: 0 walker, 1 base, otherwise another target.
 * Upper 4 bits: state of the track, 0 ok, 1 degraded, 2 lost, 3 reacquired, 4 clipped, 5 perhaps at a neighbour's place, 6 lost in a picture that is delivered twice or torn.
 */
export interface Mark { x: number; y: number; width: number; height: number; kind: number }

export interface PictureFrame {
    what: "picture";
    camera: number;  // counts from 0
    t0: number;      // s
    width: number;   // px
    height: number;
    gap: boolean;
    marks: Mark[];
    jpeg: Uint8Array<ArrayBuffer>;
}

export type Frame = SampleFrame | PictureFrame;

export class FrameError extends Error {}

function need(buffer: ArrayBuffer, bytes: number): void {
    if (buffer.byteLength < bytes)
        throw new FrameError(`a message of ${buffer.byteLength} bytes, expected ${bytes}`);
}

function picture(buffer: ArrayBuffer, view: DataView, stream: number, bytes: number): PictureFrame {
    need(buffer, headerBytes + 8);
    const marks = view.getUint16(headerBytes + 4, true);
    const boxes = headerBytes + 8;
    const kinds = boxes + 16 * marks;
    const start = kinds + Math.ceil(marks / 4) * 4;
    need(buffer, Math.max(start + bytes, boxes + markBytes * marks));
    return {
        what: "picture",
        camera: stream - firstCamera,
        t0: view.getFloat64(16, true),
        width: view.getUint16(headerBytes, true),
        height: view.getUint16(headerBytes + 2, true),
        gap: (view.getUint16(38, true) & 1) !== 0,
        marks: Array.from({ length: marks }, (_, i) => ({
            x: view.getFloat32(boxes + 16 * i, true),
            y: view.getFloat32(boxes + 16 * i + 4, true),
            width: view.getFloat32(boxes + 16 * i + 8, true),
            height: view.getFloat32(boxes + 16 * i + 12, true),
            kind: view.getUint8(kinds + i),
        })),
        jpeg: new Uint8Array(buffer, start, bytes),
    };
}

/** Decodes a message without copying it. Throws FrameError when it is not a frame or is shorter than its header states. */
export function decodeFrame(buffer: ArrayBuffer): Frame {
    need(buffer, headerBytes);
    const view = new DataView(buffer);
    if (view.getUint32(0, true) !== magic) throw new FrameError("a binary message without the magic number");
    if (view.getUint16(4, true) !== version)
        throw new FrameError(`a message of version ${view.getUint16(4, true)}; this page reads version ${version}`);
    const stream = view.getUint16(6, true);
    const count = view.getUint32(32, true);
    if (stream >= firstCamera) return picture(buffer, view, stream, count);
    const channels = view.getUint16(36, true);
    const flags = view.getUint16(38, true);
    need(buffer, headerBytes + 4 * count * channels);
    return {
        what: "samples",
        stream,
        first: Number(view.getBigUint64(8, true)),
        t0: view.getFloat64(16, true),
        dt: view.getFloat64(24, true),
        count,
        channels,
        gap: (flags & 1) !== 0,
        pairs: (flags & 2) !== 0,
        decimated: (flags & 4) !== 0,
        values: new Float32Array(buffer, headerBytes, count * channels),
    };
}

/** One channel, multiplied by `scale`. Values that are not finite become null, which uPlot does not draw. */
export function channel(frame: SampleFrame, index: number, scale: number): (number | null)[] {
    return Array.from({ length: frame.count }, (_, i) => {
        const value = (frame.values[i * frame.channels + index] ?? NaN) * scale;
        return Number.isFinite(value) ? value : null;
    });
}
