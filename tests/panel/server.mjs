// A simulated daemon on loopback: the page's files with their security policy, the socket, the actions.
import { createServer } from "node:http";
import { readFile } from "node:fs/promises";
import { join } from "node:path";
import { Bench } from "./bench.mjs";
import { samples, picture } from "./frames.mjs";
import { makePictures, places, views, walkerBox } from "./pictures.mjs";
import { bundle } from "./sources.mjs";
import { accept } from "./websocket.mjs";

const types = { "/": ["index.html", "text/html; charset=utf-8"], "/panel.js": ["panel.js", "text/javascript"], "/panel.css": ["panel.css", "text/css"] };
const policy = "default-src 'self'";
const tick = 1 / 30;  // s
const accelerationRate = 4000;

export async function startServer(folder, port = 0) {
    const clients = new Set();
    let played = null;
    const bench = new Bench((event) => { if (!played?.mute) for (const client of clients) client.text(event); });
    const pictures = makePictures();
    played = { bench, requests: [], refuse: null, silent: false, mute: false, port: 0, dropAll, close, subscribed: () => [...clients].flatMap((c) => [...c.streams.keys()]) };

    /** Sends the points again when they have changed, as the daemon does. */
    function stateFor(client) {
        const { points, ...rest } = bench.message();
        if (client.points === points.length) return rest;
        client.points = points.length;
        return { ...rest, points };
    }

    const files = createServer((request, response) => void serve(request, response));
    async function serve(request, response) {
        if (request.method === "POST") return action(request, response);
        if (request.url === "/api/recordings") return response.writeHead(200, { "Content-Type": "application/json" }).end(JSON.stringify({ recordings: bench.recordings, campaigns: bench.campaigns }));
        const [, kept] = /^\/api\/trip\/pictures\/(\d)$/.exec(request.url) ?? [];
        if (kept && bench.trip) return response.writeHead(200, { "Content-Type": "application/octet-stream" }).end(Buffer.concat(cameraFrame(Number(kept))));
        if (request.url === "/api/law") return response.writeHead(200, { "Content-Type": "application/json" }).end(JSON.stringify(bench.law()));
        if (request.url === "/api/orders") return response.writeHead(200, { "Content-Type": "application/json" }).end("[]");
        if (request.url === "/api/repeats") return response.writeHead(200, { "Content-Type": "application/json" }).end(JSON.stringify({ repeats: bench.repeats }));
        if (request.url === "/api/results.csv") return response.writeHead(200, { "Content-Type": "text/csv" }).end(`${request.headers["x-shaker-token"]},${bench.rows.length}`);
        const [name, type] = types[request.url] ?? [];
        response.setHeader("Content-Security-Policy", policy);
        if (!name) return response.writeHead(request.url === "/favicon.ico" ? 204 : 404).end();
        response.writeHead(200, { "Content-Type": type, "Cache-Control": "no-store" }).end(await readFile(join(folder, name)));
    }
    async function action(request, response) {
        let text = "";
        for await (const chunk of request) text += chunk;
        const name = request.url.replace("/api/", ""), body = text ? JSON.parse(text) : null;
        const daemon = request.headers["x-shaker-daemon"] ?? null;
        played.requests.push({ name, body, token: request.headers["x-shaker-token"] ?? null, daemon });
        if (played.silent) return request.socket.destroy();
        const error = played.refuse ?? bench.act(name, body, daemon);
        response.writeHead(!error ? 200 : name === "abort" && played.refuse ? 504 : 409, { "Content-Type": "application/json" }).end(JSON.stringify(error ? { error } : { ok: true }));
        if (!error) for (const client of clients) client.text(stateFor(client));
    }

    files.on("upgrade", (request, socket) => {
        if (played.silent) return socket.destroy();
        const streams = new Map();
        const client = accept(request, socket, (text) => {
            const message = JSON.parse(text);
            if (message.type === "subscribe") streams.set(message.stream, { ...message, due: 0 });
            else streams.delete(message.stream);
        }, () => clients.delete(client));
        client.streams = streams;
        clients.add(client);
        if (played.mute) return;
        for (const event of bench.events) client.text(event);
        client.text({ type: "results", results: bench.rows });
        client.text(stateFor(client));
    });

    const makers = {
        waveform: () => {
            const n = 400, period = 1 / bench.drive.frequency_hz, dt = (2 * period) / n;
            const rows = Array.from({ length: n }, (_, i) => bench.acceleration(i * dt));
            return samples(2, [rows.map((r) => r[0]), rows.map((r) => r[1])], { t0: bench.time, dt });
        },
        cycle: () => {
            const { x, v, vB, period } = bench.motion;
            const noise = (size) => bench.level * (bench.random() - 0.5) * size;
            return samples(3, [
                x.map((value) => bench.level * value + noise(4e-6)), x.map(() => 4e-6), v.map((value) => bench.level * value + noise(1e-3)),
                v.map(() => 1.2e-3), vB.map((value) => bench.level * value),
            ], { t0: bench.time, dt: period / x.length });
        },
        track: () => {
            const base = bench.level * 2e-4 * Math.sin(2 * Math.PI * bench.drive.frequency_hz * bench.time);
            return samples(4, [[bench.x], [base]], { t0: bench.time, dt: tick });
        },
        acceleration: ({ rate_hz }) => {
            const n = Math.floor(accelerationRate / rate_hz), start = bench.time;
            const rows = Array.from({ length: n }, (_, i) => bench.acceleration(start + i / accelerationRate));
            return samples(1, [rows.map((r) => r[0]), rows.map((r) => r[1])], { t0: start, dt: 1 / accelerationRate });
        },
    };
    function cameraFrame(k) {
        const place = Math.round(((bench.x + 0.03) / 0.06) * (places - 1)), view = views[k];
        const lost = { x: NaN, y: NaN, width: view.walker.size, height: view.walker.size, kind: 2 << 4 };
        const marks = [{ ...view.base, kind: 1 }, bench.walker_lost ? lost : { ...walkerBox(view, place), kind: 0 }];
        return picture(k, pictures[k][place], view.width, view.height, marks, { t0: bench.time });
    }
    let ticks = 0;
    const timer = setInterval(() => {
        bench.step(tick);
        ticks++;
        for (const client of played.mute ? [] : clients) {
            if (client.backlog() > 1 << 20) continue;  // a slow client misses messages, the bench does not wait
            if (ticks % 3 === 0) client.text(stateFor(client));
            for (const wish of client.streams.values()) {
                if (bench.time < wish.due) continue;
                wish.due = bench.time + 1 / wish.rate_hz - tick / 2;
                const k = views.findIndex((view) => wish.stream === `camera:${view.name}`);
                const message = k >= 0 ? cameraFrame(k) : makers[wish.stream]?.(wish);
                if (message) client.binary(message);
            }
        }
    }, 1000 * tick);

    function dropAll() { for (const client of clients) client.drop(); }
    function close() {
        clearInterval(timer);
        dropAll();
        files.closeAllConnections();
        files.close();
    }
    await new Promise((ready) => files.listen(port, "127.0.0.1", ready));
    played.port = files.address().port;
    return played;
}

if (process.argv[1]?.endsWith("/tests/panel/server.mjs")) {
    const { port } = await startServer(process.argv[2] ?? bundle, Number(process.argv[3] ?? 8080));
    console.log(`http://127.0.0.1:${port}/`);
}
