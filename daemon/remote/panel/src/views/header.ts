// State, recording, connection, and progress of an abort.
import type { Abort, AbortStatus } from "../abort";
import { noAnswer } from "../actions";
import type { Connection } from "../connection";
import { byId, setData, setHidden, setText } from "../dom";
import { clockTime, duration, fixed } from "../format";
import { driving, type RunState, type Session } from "../protocol";
import type { Store } from "../store";

const answerPatience = 1500;  // ms after a press of ABORT

/** Each state has a sign beside its word, so that states differ without colours. */
const words: Record<RunState, string> = {
    starting: "… starting", idle: "○ idle", armed: "◇ armed", identifying: "≈ identifying", checking: "∿ checking", ramping: "▲ ramping", settling: "◐ settling",
    running: "● running", stopping: "▼ stopping", tripped: "✖ tripped", finishing: "◌ finishing",
};

export function makeHeader(store: Store, connection: Connection, abort: Abort): () => void {
    const title = byId("title", HTMLElement), program = byId("program", HTMLElement);
    const state = byId("state", HTMLElement), more = byId("state-more", HTMLElement);
    const recording = byId("recording", HTMLElement);
    const link = byId("link", HTMLElement), status = byId("abort-status", HTMLElement);
    const hardwareStop = byId("hardware-stop", HTMLElement);
    byId("abort", HTMLButtonElement).addEventListener("click", () => void abort.send());

    const showSession = (session: Session): void => {
        const kind = session.state === "tripped" ? "tripped" : driving.has(session.state) ? "driving" : "silent";
        setText(title, session.program);
        setText(program, `${session.program} ${session.version}`);
        setText(state, session.to_middle && kind === "driving" ? "↔ to the middle" : words[session.state] ?? session.state);
        setData(state, "kind", kind);
        setText(more, `for ${duration(session.since_s)}, on ${session.rig || "no rig"}`);
        setHidden(recording, session.recording === null && !session.record_next);
        setText(recording, recordingWords(session));
    };

    return () => {
        const session = store.state?.session ?? null;
        if (session) showSession(session);
        showLink(link, connection);
        setText(status, abortWords(abort.status));
        showHardwareStop(hardwareStop, hardwareStopWords(abort.status, performance.now(), connection.lostAt !== null));
        setData(status, "kind", ["sending", "other", "failed"].includes(abort.status.state) ? "trouble" : "calm");
        const words = pageTitle(session, connection);
        if (document.title !== words) document.title = words;
    };
}

/** Screen readers read out each change of this alert, so its text must not change every second. */
function showLink(link: HTMLElement, connection: Connection): void {
    const { lostAt } = connection;
    document.body.classList.toggle("stale", lostAt !== null);
    setHidden(link, lostAt === null);
    if (lostAt === null) return;
    const since = clockTime((performance.now() - lostAt) / 1e3);
    const what = connection.heard ? "The values shown are old." : "Nothing was received yet.";
    setText(link, `Not connected since ${since}. ${what} Reconnecting; ABORT is still sent.`);
}

/** The text of the bar below the head while an abort is not answered; empty: no bar. now: performance.now(). */
export function hardwareStopWords(status: AbortStatus, now: number, lost: boolean): string {
    const waits = status.state === "sending" && now - status.since > answerPatience;
    if (!waits && !(status.state === "failed" && lost)) return "";
    if (status.error === null || status.error === noAnswer) return "No answer from the daemon: press the hardware stop NOW";
    return `The daemon did not stop the drive (${status.error}): press the hardware stop NOW`;
}

function showHardwareStop(bar: HTMLElement, words: string): void {
    setHidden(bar, words === "");
    setText(bar, words);
}

function recordingWords({ recording, finishing, record_next, record_name }: Session): string {
    if (finishing && recording !== null) return `◌ finishing ${recording}`;
    if (recording !== null) return `● recording ${recording}`;
    if (!record_next) return "";
    return record_name === null ? "○ next run is recorded, named by its time" : `○ next run is recorded: ${record_name}.nxs`;
}

function pageTitle(session: Session | null, connection: Connection): string {
    if (connection.lostAt !== null) return "not connected – shakerd";
    return session ? `${session.state} – ${session.program}` : "shakerd";
}

function abortWords(status: AbortStatus): string {
    switch (status.state) {
        case "ready": return "Esc or Space";
        case "sending":
            return status.error ? `ABORT not confirmed: ${status.error}; attempt ${status.attempt}` : "ABORT sent…";
        case "done": return `ABORT received, ${fixed(status.took_ms, 0)} ms`;
        case "other": return `ABORT not done: ${status.error}`;
        case "failed": return `ABORT failed: ${status.error}. Use the hardware stop!`;
    }
}
