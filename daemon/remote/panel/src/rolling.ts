// The last points of a live stream in a fixed amount of memory, and their envelope for a plot.
import type { SampleFrame } from "./frames";

type Column = (number | null)[];

export class Rolling {
    private readonly times: Float64Array;
    private readonly values: Float32Array;
    private next = 0;
    private held = 0;
    /** Incremented by each frame. */
    version = 0;

    constructor(private readonly capacity: number, readonly channels: number) {
        this.times = new Float64Array(capacity);
        this.values = new Float32Array(capacity * channels);
    }

    get size(): number { return this.held; }
    get newest(): number { return this.held ? this.time(this.held - 1) : NaN; }

    /** A gap or a backward step of time (another run, another daemon) interrupts the curve. */
    push(frame: SampleFrame): void {
        if (frame.channels !== this.channels || frame.count === 0) return;
        if (frame.t0 < this.newest) this.clear();
        if (frame.gap && this.held) this.row(frame.t0, () => NaN);
        for (let i = 0; i < frame.count; i++)
            this.row(frame.t0 + i * frame.dt, (c) => frame.values[i * frame.channels + c] ?? NaN);
        this.version++;
    }

    clear(): void {
        this.next = this.held = 0;
        this.version++;
    }

    /**
     * [seconds before `end`, least, greatest, least, greatest, ...], one pair per channel, for the last `window` seconds in
     * at most buckets + 1 points. Buckets with a gap have no values.
     */
    envelope(end: number, window: number, buckets: number, scale: number): Column[] {
        const columns: Column[] = Array.from({ length: 2 * this.channels + 1 }, () => []);
        const width = window / buckets;
        let i = this.held;
        while (i > 0 && this.time(i - 1) >= end - window) i--;
        while (i < this.held) {
            // Buckets are fixed on the time axis; otherwise the moving envelope would flicker.
            const bucket = Math.floor(this.time(i) / width);
            let stop = i + 1;
            while (stop < this.held && Math.floor(this.time(stop) / width) === bucket) stop++;
            columns[0]!.push((bucket + 0.5) * width - end);
            for (let c = 0; c < this.channels; c++) {
                const [least, greatest] = this.extremes(i, stop, c);
                columns[2 * c + 1]!.push(finite(least * scale));
                columns[2 * c + 2]!.push(finite(greatest * scale));
            }
            i = stop;
        }
        return columns;
    }

    private extremes(from: number, stop: number, c: number): [number, number] {
        let least = Infinity, greatest = -Infinity;
        for (let k = from; k < stop; k++) {
            const value = this.value(k, c);
            if (Number.isNaN(value)) return [NaN, NaN];
            if (value < least) least = value;
            if (value > greatest) greatest = value;
        }
        return [least, greatest];
    }

    private row(time: number, value: (channel: number) => number): void {
        this.times[this.next] = time;
        for (let c = 0; c < this.channels; c++) this.values[this.next * this.channels + c] = value(c);
        this.next = (this.next + 1) % this.capacity;
        this.held = Math.min(this.held + 1, this.capacity);
    }

    private slot(i: number): number { return (this.next - this.held + i + this.capacity) % this.capacity; }
    private time(i: number): number { return this.times[this.slot(i)]!; }
    private value(i: number, c: number): number { return this.values[this.slot(i) * this.channels + c]!; }
}

function finite(value: number): number | null { return Number.isFinite(value) ? value : null; }
