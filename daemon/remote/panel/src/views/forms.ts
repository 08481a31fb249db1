// The forms of the page except that of the drive: start, return to the middle, friction, recording, remark, control.
import type { Actions } from "../actions";
import { byId, setHidden, setText } from "../dom";
import { duration, fixed, number } from "../format";
import { driving, type Known, type RecordedSize, type Session, type State } from "../protocol";
import type { Store } from "../store";
import { makeDriveForm } from "./drive_form";
import { wire } from "./form";
import { outlookOf, type Asked } from "./outlook";

const nearEdge = 1e-3;  // m, inside the limit

function form(id: string): HTMLFormElement { return byId(id, HTMLFormElement); }

function untilStopped(): boolean { return byId("how-long", HTMLSelectElement).value === "open"; }

/** The run as typed; a field that is not a whole number from its least is null. */
function askedRun(state: State | null): Asked {
    const whole = (id: string, least: number, otherwise: number | null): number | null => {
        const { value } = byId(id, HTMLInputElement), count = Number(value);
        if (value.trim() === "") return otherwise;
        return Number.isInteger(count) && count >= least ? count : null;
    };
    return { periods: whole("periods", 2, state?.result.periods ?? null), measurements: untilStopped() ? null : whole("measurements", 1, 1) };
}

/** Empty while something is driven or the numbers are incomplete. */
function showOutlook(state: State): void {
    const line = byId("outlook", HTMLElement), asked = askedRun(state);
    const shown = !driving.has(state.session.state) && edgeWords(state) === "";
    const { text, trouble } = shown ? outlookOf(state, asked) : { text: "", trouble: false };
    setText(line, text);
    setHidden(line, text === "");
    line.classList.toggle("warn", trouble);
    byId("measurements", HTMLInputElement).disabled = untilStopped();
}

function wireStart(act: Actions): void {
    const periods = byId("periods", HTMLInputElement), measurements = byId("measurements", HTMLInputElement);
    wire(form("start"), act, () => {
        if (periods.validity.badInput) return { refused: "periods: expected a whole number or an empty field" };
        const asked = askedRun(null);
        if (periods.value !== "" && asked.periods === null) return { refused: "periods: a whole number from 2" };
        if (!untilStopped() && (measurements.value === "" || asked.measurements === null))
            return { refused: "measurements: a whole number from 1" };
        return { ...(asked.periods === null ? {} : { periods: asked.periods }), measurements: asked.measurements ?? 0 };
    });
}

function wireMu(act: Actions): void {
    const value = byId("mu-value", HTMLInputElement);
    wire(form("give-mu"), act, () => {
        const mu = Number(value.value);
        return value.value.trim() !== "" && mu > 0 ? { mu } : { refused: "friction: a number above 0 is needed, for example 0.113" };
    }, () => { value.value = ""; });
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

const primaries = ["clear-button", "stop-button", "resume-button", "middle-button", "drive-set", "start-button"] as const;

/** The one button that stands out: the order that comes next in this state. Null: none. */
export function nextOrder(state: State, edited: boolean): (typeof primaries)[number] | null {
    const { session, campaign } = state;
    if (session.state === "tripped") return "clear-button";
    if (driving.has(session.state)) return "stop-button";
    if (session.state !== "idle" && session.state !== "armed") return null;
    if (campaign?.active) return campaign.paused ? "resume-button" : null;
    return edgeWords(state) !== "" ? "middle-button" : edited ? "drive-set" : "start-button";
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
    wireStart(act);
    wireRemark(act);
    wire(form("middle"), act, () => ({}));
    wire(form("reset-walker"), act, () => ({}));
    wireMu(act);
    const showRecord = wireRecord(act, store);
    const showDrive = makeDriveForm(act, store);
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
        const next = nextOrder(state, showDrive(state));
        for (const id of primaries) byId(id, HTMLButtonElement).classList.toggle("primary", id === next);
        showMiddle(state);
        showOutlook(state);
    };
}

function holderWords({ you_control, controller }: Session): string {
    if (you_control) return "✓ You have control.";
    return controller ? `${controller} has control; you watch.` : "Control is free: your next order takes it.";
}
