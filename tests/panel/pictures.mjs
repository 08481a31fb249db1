// Pictures of the two cameras for a walker at 24 places, made once with Debian's ffmpeg.
import { execFileSync } from "node:child_process";

export const places = 24;
export const views = [
    { name: "top", width: 640, height: 160, base: { x: 20, y: 34, width: 600, height: 96 }, walker: { y: 50, size: 64 } },
    { name: "side", width: 640, height: 120, base: { x: 20, y: 82, width: 600, height: 26 }, walker: { y: 34, size: 48 } },
];

export function walkerBox(view, place) {
    const { base, walker } = view;
    const x = base.x + 20 + (place / (places - 1)) * (base.width - 40 - walker.size);
    return { x, y: walker.y, width: walker.size, height: walker.size };
}

function grey(view, place) {
    const pixels = Buffer.alloc(view.width * view.height);
    const box = walkerBox(view, place), { base } = view;
    for (let y = 0; y < view.height; y++)
        for (let x = 0; x < view.width; x++) {
            let value = 28 + ((x * 7 + y * 13) % 11);
            if (y >= base.y && y < base.y + base.height && x >= base.x && x < base.x + base.width)
                value = 96 + ((x >> 4) % 2) * 14;
            const dx = x - box.x - box.width / 2, dy = y - box.y - box.height / 2;
            if (Math.hypot(dx, dy) < box.width / 2) value = 190 + dy;
            if (Math.hypot(dx, dy) < 5) value = 20;
            pixels[y * view.width + x] = value;
        }
    return pixels;
}

/** pictures[camera][place] is a JPEG. */
export function makePictures() {
    return views.map((view) => {
        const raw = Buffer.concat(Array.from({ length: places }, (_, place) => grey(view, place)));
        const stream = execFileSync("ffmpeg", [
            "-loglevel", "error", "-threads", "1", "-f", "rawvideo", "-pix_fmt", "gray", "-s", `${view.width}x${view.height}`,
            "-i", "-", "-f", "image2pipe", "-c:v", "mjpeg", "-pix_fmt", "yuvj420p", "-q:v", "5", "-",
        ], { input: raw, maxBuffer: 64 << 20 });
        const jpegs = [];
        for (let start = 0; start < stream.length;) {
            const end = stream.indexOf(Buffer.from([0xff, 0xd9]), start) + 2;
            jpegs.push(stream.subarray(start, end));
            start = end;
        }
        if (jpegs.length !== places) throw new Error(`${jpegs.length} pictures of ${places}`);
        return jpegs;
    });
}
