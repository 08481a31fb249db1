// ABORT: sent at once and repeated until the daemon confirms it.
import type { Actions } from "./actions";

const attemptPatience = 1500;  // ms
const firstPause = 100;        // ms, doubled up to the longest
const longestPause = 1000;
const giveUpAfter = 60_000;    // ms; a later abort could stop a run that somebody else has started since

export type AbortStatus =
    | { state: "ready" }
    | { state: "sending"; attempt: number; error: string | null }
    | { state: "done"; took_ms: number }
    | { state: "failed"; error: string };

export class Abort {
    status: AbortStatus = { state: "ready" };
    version = 0;

    constructor(private readonly act: Actions) {}

    async send(): Promise<void> {
        if (this.status.state === "sending") return;
        const begun = performance.now();
        let pause = firstPause;
        this.become({ state: "sending", attempt: 1, error: null });
        for (let attempt = 1; ; attempt++) {
            const answer = await this.act("abort", undefined, attemptPatience);
            const took = performance.now() - begun;
            if (answer.ok) return this.become({ state: "done", took_ms: took });
            if (took > giveUpAfter) return this.become({ state: "failed", error: answer.error });
            this.become({ state: "sending", attempt: attempt + 1, error: answer.error });
            await new Promise((resume) => setTimeout(resume, pause));
            pause = Math.min(2 * pause, longestPause);
        }
    }

    private become(status: AbortStatus): void {
        this.status = status;
        this.version++;
    }
}

const fields = new Set(["INPUT", "SELECT", "TEXTAREA"]);

/** Escape aborts always, Space unless it is needed for typing. Enter presses buttons. */
export function abortsBy(key: string, target: EventTarget | null): boolean {
    if (key === "Escape") return true;
    return key === " " && !(target instanceof HTMLElement && (fields.has(target.tagName) || target.isContentEditable));
}

export function listenForAbort(abort: Abort): void {
    const onKey = (event: KeyboardEvent): void => {
        if (event.isComposing || event.ctrlKey || event.altKey || event.metaKey) return;
        if (!abortsBy(event.key, event.target)) return;
        event.preventDefault();  // no click on a focused button, no scrolling
        event.stopPropagation();
        if (event.type === "keydown" && !event.repeat) void abort.send();
    };
    window.addEventListener("keydown", onKey, { capture: true });
    window.addEventListener("keyup", onKey, { capture: true });
}
