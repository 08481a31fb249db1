// The forms of the page except that of the drive: start, return to the middle, friction, recording, remark, control.
import type { Actions } from "../actions";
import { byId, setHidden, setText } from "../dom";
import { duration, fixed, number } from "../format";
import { driving, type Known, type RecordedSize, type Session, type State } from "../protocol";
import { typed, whole, type Typed } from "../quantity";
import type { Store } from "../store";
import { makeDriveForm, type DriveForm } from "./drive_form";
import { watchForm, wire, type Refused } from "./form";
import { outlookOf } from "./outlook";

const nearEdge = 1e-3;  // m, inside the limit

function form(id: string): HTMLFormElement { return byId(id, HTMLFormElement); }

function untilStopped(): boolean { return byId("how-long", HTMLSelectElement).value === "open"; }

/** The run as typed; null: the field is empty. */
function askedRun(): { periods: number | null; measurements: number | null } | Refused {
    const { value } = byId("periods", HTMLInputElement);
    const periods = value.trim() === "" ? null : whole("periods", value, 3);
    if (periods !== null && typeof periods !== "number") return periods;
    const measurements = untilStopped() ? null : whole("measurements", byId("measurements", HTMLInputElement).value, 1);
    return measurements !== null && typeof measurements !== "number" ? measurements : { periods, measurements };
}

/** Empty while something is driven or the numbers are incomplete. */
function showOutlook(state: State): void {
    const line = byId("outlook", HTMLElement), run = askedRun();
    const shown = !("refused" in run) && !driving.has(state.session.state) && edgeWords(state) === "";
    const { text, trouble } = shown ? outlookOf(state, { ...run, periods: run.periods ?? state.result.periods }) : { text: "", trouble: false };
    setText(line, text);
    setHidden(line, text === "");
    line.classList.toggle("warn", trouble);
    byId("measurements", HTMLInputElement).disabled = untilStopped();
}

/** Start sends the edited fields of the drive with it: the daemon sets the drive and begins the run, or does neither. */
function wireStart(act: Actions, drive: DriveForm): void {
    const body = (): Record<string, unknown> | Refused => {
        const run = askedRun(), edits = drive.edits();
        if ("refused" in edits) return edits;
        if ("refused" in run) return run;
        return { ...edits.body, ...(run.periods === null ? {} : { periods: run.periods }), measurements: run.measurements ?? 0 };
    };
    const show = watchForm(form("start"), () => {
        const order = body(), edits = drive.edits();
        if ("refused" in order) return order as Refused;
        return "words" in edits && edits.words ? `will be sent first: ${edits.words}` : "";
    });
    wire(form("start"), act, body, drive.accepted);
    drive.onEdit(show);
}

function wireMu(act: Actions): void {
    const value = byId("mu-value", HTMLInputElement);
    const mu = (): Typed | Refused => typed("friction", value.value, "");
    const show = watchForm(form("give-mu"), () => {
        const given = mu();
        if (value.value.trim() === "") return "";
        return "refused" in given ? given : `will be sent: ${given.words}`;
    });
    wire(form("give-mu"), act, () => {
        const given = mu();
        return "refused" in given ? given : { mu: given.text };
    }, () => {
        value.value = "";
        show();
    });
}

/** A walker beyond the limit at the edge, or so near that hardly a drive may start: what leads out. */
export function edgeWords({ walker, limits, session }: Pick<State, "walker" | "limits" | "session">): string {
    const least = limits["edge_m"], edge = walker?.edge_m ?? null;
    if (session.state !== "idle" && session.state !== "armed") return "";
    if (edge === null || typeof least !== "number" || edge >= least + nearEdge) return "";
    return `The walker is ${fixed(1e3 * edge, 1)} mm from the edge of the picture (limit ${fixed(1e3 * least, 1)} mm). Bring it to the middle before the next run.`;
}

function showMiddle(state: State): void {
    const words = edgeWords(state), edge = byId("edge", HTMLElement);
    setHidden(edge, words === "");
    setText(edge, words);
    const mu = state.result.mu?.value ?? null;
    byId("mu-value", HTMLInputElement).placeholder = mu === null ? "not known" : number(mu);
}

const primaries = ["clear-button", "stop-button", "resume-button", "middle-button", "start-button"] as const;

/** The one button that stands out: the order that comes next in this state. Null: none. */
export function nextOrder(state: State): (typeof primaries)[number] | null {
    const { session, campaign } = state;
    if (session.state === "tripped") return "clear-button";
    if (driving.has(session.state)) return "stop-button";
    if (session.state !== "idle" && session.state !== "armed") return null;
    if (campaign?.active) return campaign.paused ? "resume-button" : null;
    return edgeWords(state) !== "" ? "middle-button" : "start-button";
}

function asked(session: Session): boolean { return session.recording !== null || session.record_next; }

/** How long a recording the disk takes; `room`: bytes without those that must stay free. */
export function roomWords(room: Known, size: RecordedSize | undefined): string {
    if (room === null || !size) return "";
    const left = room - size.first_bytes;
    return left <= 0 ? "⚠ The disk is full: nothing can be recorded." : `The disk has room for ${duration(left / size.bytes_per_s)} of recording.`;
}

/**
 * One button requests the recording of the next run, cancels the request, or ends a recording. Its label shows which. Until
 * the run starts, a changed name or kind of pictures is sent, and so checked, at once.
 */
function wireRecord(act: Actions, store: Store): (state: State) => void {
    const name = byId("record-name", HTMLInputElement), frames = byId("record-frames", HTMLSelectElement);
    const button = byId("record-button", HTMLButtonElement);
    let changed = false;
    const waits = (): boolean => store.state !== null && store.state.session.record_next && store.state.session.recording === null;
    wire(form("record"), act, () => {
        const session = store.state?.session;
        if (session && asked(session) && !changed) return { name: null, frames: frames.value };
        changed = false;
        const text = name.value.trim();
        return text ? { name: text, frames: frames.value } : { refused: "name: needed" };
    });
    const sendAgain = (): void => {
        changed = waits();
        if (changed) form("record").requestSubmit();
    };
    name.addEventListener("change", sendAgain);
    frames.addEventListener("change", sendAgain);
    name.addEventListener("keydown", (event) => {
        if (event.key !== "Enter" || !waits()) return;
        event.preventDefault();  // it would press the button, which cancels the request
        name.blur();
    });
    const room = byId("record-room", HTMLElement);
    let shown: string | null = null;
    return ({ session, disk, outlook }) => {
        if (session.frames !== shown && session.frames !== null) frames.value = shown = session.frames;
        for (const option of frames.options) option.disabled = Object.keys(outlook.recorded).length > 0 && !(option.value in outlook.recorded);
        setText(room, roomWords(disk.room_bytes, outlook.recorded[frames.value]));
        setText(button, session.recording !== null ? "End the recording" : session.record_next ? "Do not record" : "Record");
        name.disabled = frames.disabled = session.recording !== null;
    };
}

/** Sends a remark for log and recording. The text stays in its field until the daemon has accepted it. */
function wireRemark(act: Actions): void {
    const remark = byId("remark-text", HTMLInputElement);
    wire(form("remark"), act, () => {
        const text = remark.value.trim();
        return text ? { text } : { refused: "remark: needed" };
    }, () => { remark.value = ""; });
}

export function makeForms(act: Actions, store: Store): () => void {
    for (const simple of document.querySelectorAll<HTMLFormElement>("form:not([id])")) wire(simple, act, () => ({}));
    wire(form("take"), act, () => ({}));
    wire(form("release"), act, () => ({}));
    const drive = makeDriveForm(act, store);
    wireStart(act, drive);
    wireRemark(act);
    wire(form("middle"), act, () => ({}));
    wire(form("reset-walker"), act, () => ({}));
    wireMu(act);
    const showRecord = wireRecord(act, store);
    const holder = byId("holder", HTMLElement), clear = byId("clear-button", HTMLButtonElement);
    let seen = -1;
    return () => {
        const { state } = store;
        if (!state || seen === store.stateVersion) return;
        seen = store.stateVersion;
        const { session } = state;
        setText(holder, holderWords(session));
        clear.disabled = session.state === "tripped" && !session.may_clear;
        setHidden(form("take"), session.you_control);
        setHidden(form("release"), !session.you_control);
        setHidden(form("reset-walker"), !session.simulated);
        showRecord(state);
        drive.show(state);
        const next = nextOrder(state);
        for (const id of primaries) byId(id, HTMLButtonElement).classList.toggle("primary", id === next);
        showMiddle(state);
        showOutlook(state);
    };
}

function holderWords({ you_control, controller }: Session): string {
    if (you_control) return "✓ You have control.";
    return controller ? `${controller} has control; you watch.` : "Control is free: your next order takes it.";
}
