// ABORT: sent at once and repeated until the daemon confirms it. A repeated one names the daemon for which it was pressed, so
// that it does not trip another one that was started since and is at rest.
import type { Actions } from "./actions";

const attemptPatience = 1500;  // ms
const firstPause = 100;        // ms, doubled up to the longest
const longestPause = 1000;
const conflict = 409;          // HTTP: the abort was for another daemon
const giveUpAfter = 60_000;    // ms; a later abort could stop a run that somebody else has started since

export type AbortStatus =
    | { state: "ready" }
    | { state: "sending"; attempt: number; error: string | null; since: number }  // since: performance.now() at the press
    | { state: "done"; took_ms: number }
    | { state: "other"; error: string }  // the daemon of the press is gone, another one is at rest
    | { state: "failed"; error: string };

export class Abort {
    status: AbortStatus = { state: "ready" };
    version = 0;
    private fresh = false;  // a press that was not sent yet
    private pressedFor = "";
    private hurry = (): void => undefined;  // ends the pause between two attempts

    /** daemon: identity of the daemon whose state the page shows; empty: not known. */
    constructor(private readonly act: Actions, private readonly daemon: () => string) {}

    /** A press while an earlier one is repeated is a new one: it acts on any daemon. */
    async send(): Promise<void> {
        this.fresh = true;
        this.pressedFor = this.daemon();
        this.hurry();
        if (this.status.state === "sending") return;
        const since = performance.now();
        let pause = firstPause;
        this.become({ state: "sending", attempt: 1, error: null, since });
        for (let attempt = 1; ; attempt++) {
            const named = !this.fresh;
            this.fresh = false;
            const answer = await this.act("abort", undefined, attemptPatience, named ? this.pressedFor : "");
            const took = performance.now() - since;
            if (answer.ok) return this.become({ state: "done", took_ms: took });
            this.become({ state: "sending", attempt: attempt + 1, error: answer.error, since });
            if (this.fresh) continue;
            if (named && answer.status === conflict) return this.become({ state: "other", error: answer.error });
            if (took > giveUpAfter) return this.become({ state: "failed", error: answer.error });
            await new Promise<void>((resume) => {
                this.hurry = resume;
                setTimeout(resume, pause);
            });
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
