// The socket to the daemon. It reconnects by itself and treats silence as a lost connection.

const silentAfter = 2500;  // ms; a state comes ten times a second
const firstDelay = 250;    // ms, doubled up to the longest
const longestDelay = 4000;

interface Receiver {
    text(message: string): void;
    binary(message: ArrayBuffer): void;
    connected(): void;
}

export class Connection {
    /** performance.now() at the loss of the connection; null while connected. */
    lostAt: number | null = performance.now();
    /** True after the first message. */
    heard = false;
    private socket: WebSocket | null = null;
    private delay = firstDelay;
    private heardAt = 0;
    private retry = 0;
    private readonly wanted = new Map<string, string>();

    constructor(private readonly receiver: Receiver, private readonly url: string) {
        window.setInterval(() => this.watch(), 500);
        window.addEventListener("online", () => this.hurry());
        document.addEventListener("visibilitychange", () => { if (!document.hidden) this.hurry(); });
        this.open();
    }

    /** Requests a stream now and after each reconnect. A new width or rate replaces the previous request. */
    subscribe(stream: string, width: number, rate: number): void {
        const message = JSON.stringify({ type: "subscribe", stream, width, rate_hz: rate });
        if (this.wanted.get(stream) === message) return;
        this.wanted.set(stream, message);
        this.send(message);
    }

    unsubscribe(stream: string): void {
        if (this.wanted.delete(stream)) this.send(JSON.stringify({ type: "unsubscribe", stream }));
    }

    private open(): void {
        const socket = new WebSocket(this.url);
        socket.binaryType = "arraybuffer";
        this.socket = socket;
        this.heardAt = performance.now();
        socket.onopen = () => {
            this.receiver.connected();
            for (const message of this.wanted.values()) this.send(message);
        };
        socket.onmessage = ({ data }: MessageEvent<string | ArrayBuffer>) => {
            this.heardAt = performance.now();
            this.delay = firstDelay;
            this.lostAt = null;  // only after a message: a silent server is not the daemon
            this.heard = true;
            if (typeof data === "string") this.receiver.text(data);
            else this.receiver.binary(data);
        };
        socket.onclose = () => this.lost(socket);
    }

    private lost(socket: WebSocket): void {
        if (socket !== this.socket) return;
        this.socket = null;
        this.lostAt ??= this.heardAt;
        this.retry = window.setTimeout(() => this.open(), this.delay * (0.75 + Math.random() / 2));
        this.delay = Math.min(2 * this.delay, longestDelay);
    }

    /** Drops a silent socket at once, because closing it would wait for the other side. */
    private watch(): void {
        const { socket } = this;
        if (!socket || performance.now() - this.heardAt < silentAfter) return;
        socket.onmessage = socket.onopen = null;
        socket.close();
        this.lost(socket);
    }

    private hurry(): void {
        if (this.socket) return;
        window.clearTimeout(this.retry);
        this.open();
    }

    private send(message: string): void {
        if (this.socket?.readyState === WebSocket.OPEN) this.socket.send(message);
    }
}
