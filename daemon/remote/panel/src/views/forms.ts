// The forms of the page except that of the drive: start, recording, remark, control.
import type { Actions } from "../actions";
import { byId, setHidden, setText } from "../dom";
import type { Session } from "../protocol";
import type { Store } from "../store";
import { makeDriveForm } from "./drive_form";
import { wire } from "./form";

function form(id: string): HTMLFormElement { return byId(id, HTMLFormElement); }

function wireStart(act: Actions): void {
    const periods = byId("periods", HTMLInputElement);
    wire(form("start"), act, () => {
        if (periods.validity.badInput) return { refused: "periods: expected a whole number or an empty field" };
        if (periods.value === "") return {};
        const count = Number(periods.value);
        return Number.isInteger(count) && count >= 1 ? { periods: count } : { refused: "periods: a whole number from 1" };
    });
}

function asked(session: Session): boolean { return session.recording !== null || session.record_next; }

/** One button requests the recording of the next run, cancels the request, or ends a recording. Its label shows which. */
function wireRecord(act: Actions, store: Store): (session: Session) => void {
    const name = byId("record-name", HTMLInputElement), frames = byId("record-frames", HTMLSelectElement);
    const button = byId("record-button", HTMLButtonElement);
    wire(form("record"), act, () => {
        const session = store.state?.session;
        if (session && asked(session)) return { name: null, frames: frames.value };
        const text = name.value.trim();
        return text ? { name: text, frames: frames.value } : { refused: "name: needed" };
    });
    return (session) => {
        setText(button, session.recording !== null ? "End the recording" : session.record_next ? "Do not record" : "Record");
        name.disabled = frames.disabled = asked(session);
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
        showRecord(session);
        showDrive(state);
    };
}

function holderWords({ you_control, controller }: Session): string {
    if (you_control) return "✓ You have control.";
    return controller ? `${controller} has control; you watch.` : "Nobody has control; you watch.";
}
