// The newest data from the daemon, in bounded memory. Views read the store when they draw; it never calls them.
import { decodeFrame, FrameError, streamIds, type PictureFrame, type SampleFrame } from "./frames";
import { parseMessage } from "./messages";
import type { LogEvent, ResultRow, State } from "./protocol";
import { newestFirst } from "./results";
import { Rolling } from "./rolling";

export const maxEvents = 500;
const maxCameras = 4, maxResults = 1000;

export class Store {
    state: State | null = null;
    /** Incremented by each state. */
    stateVersion = 0;
    readonly events: LogEvent[] = [];
    /** Number of received events; events[events.length - 1] has this number. */
    eventCount = 0;
    /** The newest rows of the table of results, by id. */
    readonly results = new Map<number, ResultRow>();
    resultsVersion = 0;
    waveform: SampleFrame | null = null;
    cycle: SampleFrame | null = null;
    readonly acceleration = new Rolling(98304, 2);
    readonly track = new Rolling(16384, 2);
    readonly pictures: (PictureFrame | null)[] = Array.from({ length: maxCameras }, () => null);
    /** Messages that could not be read. */
    unreadable = 0;
    private gaps = 0;

    /** Messages that were late or lost because this page or its network is slow. */
    get missed(): number { return this.gaps; }

    text(message: string): void {
        const parsed = parseMessage(message, this.state);
        if (!parsed) this.unreadable++;
        if (parsed?.type === "state") {
            this.state = parsed.state;
            this.stateVersion++;
        } else if (parsed?.type === "event") {
            const { id } = parsed.event;
            const before = this.events.findIndex((event) => event.id === id);
            if (before >= 0) this.events.splice(before, 1);
            this.events.push(parsed.event);
            this.eventCount++;
            if (this.events.length > maxEvents) this.events.shift();
        } else if (parsed?.type === "results") {
            for (const row of parsed.results) this.results.set(row.id, row);
            for (const old of newestFirst(this.results.values()).slice(maxResults)) this.results.delete(old.id);
            this.resultsVersion++;
        }
    }

    binary(message: ArrayBuffer): void {
        try {
            const frame = decodeFrame(message);
            if (frame.gap) this.gaps++;
            if (frame.what === "picture") {
                if (frame.camera < maxCameras) this.pictures[frame.camera] = frame;
            } else this.samples(frame);
        } catch (error) {
            if (!(error instanceof FrameError)) throw error;
            this.unreadable++;
        }
    }

    /** Removes all events and results, because the daemon sends its last ones again after each connect. */
    connected(): void {
        this.events.length = 0;
        this.eventCount = 0;
        this.results.clear();
        this.resultsVersion++;
        this.acceleration.clear();
        this.track.clear();
    }

    private samples(frame: SampleFrame): void {
        switch (frame.stream) {
            case streamIds.acceleration: this.acceleration.push(frame); break;
            case streamIds.track: this.track.push(frame); break;
            case streamIds.waveform: if (frame.channels >= 2) this.waveform = frame; break;
            case streamIds.cycle: if (frame.channels >= 5) this.cycle = frame; break;
        }
    }
}
