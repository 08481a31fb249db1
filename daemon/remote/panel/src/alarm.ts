// The alarm at a trip: a sound until somebody acknowledges it, and a notification of the browser. Off until it is switched on.
import { byId, setText } from "./dom";
import type { Store } from "./store";

const key = "shakerd-alarm";
const look = 500;       // ms between two looks at the state; also while the page is hidden, when nothing is drawn
const freshAge = 10;    // s; an older trip was there before the page was opened
const pause = 1000;     // ms between two sounds

/** Two short tones, through the browser's own synthesiser. */
function sound(audio: AudioContext): void {
    [880, 660].forEach((hertz, k) => {
        const tone = audio.createOscillator(), level = audio.createGain(), start = audio.currentTime + 0.25 * k;
        tone.frequency.value = hertz;
        level.gain.setValueAtTime(0.3, start);
        level.gain.exponentialRampToValueAtTime(0.001, start + 0.22);
        tone.connect(level).connect(audio.destination);
        tone.start(start);
        tone.stop(start + 0.24);
    });
}

export class Alarm {
    private on = localStorage.getItem(key) === "on";
    private audio: AudioContext | null = null;
    private of: number | null = null;  // trip that was last seen, s of master time
    private timer = 0;                 // of the sound; 0: silent
    private readonly toggle = byId("alarm", HTMLButtonElement);
    private readonly acknowledge = byId("acknowledge", HTMLButtonElement);

    constructor(private readonly store: Store) {
        this.toggle.addEventListener("click", () => this.switch(!this.on));
        this.acknowledge.addEventListener("click", () => this.silence());
        // A browser gives no sound before somebody has pressed something on the page.
        for (const press of ["pointerdown", "keydown"]) document.addEventListener(press, () => { if (this.on) this.wake(); });
        window.setInterval(() => this.follow(), look);
        this.show();
    }

    private wake(): void {
        this.audio ??= new AudioContext();
        if (this.audio.state === "suspended") void this.audio.resume().then(() => this.show());
        this.show();
    }

    private switch(on: boolean): void {
        this.on = on;
        localStorage.setItem(key, on ? "on" : "off");
        if (!on) this.silence();
        else if ("Notification" in window && Notification.permission === "default") void Notification.requestPermission();
        if (on) this.wake();
        this.show();
    }

    private show(): void {
        const silent = this.on && this.audio?.state !== "running";
        setText(this.toggle, this.on ? (silent ? "Alarm: press once" : "Alarm: on") : "Alarm: off");
        this.toggle.setAttribute("aria-pressed", String(this.on));
        this.acknowledge.style.visibility = this.timer === 0 ? "hidden" : "visible";
    }

    private silence(): void {
        window.clearInterval(this.timer);
        this.timer = 0;
        this.show();
    }

    private follow(): void {
        const trip = this.store.state?.session.trip ?? null;
        if (trip === null || trip.t_s === null) {
            this.of = null;
            if (this.timer !== 0) this.silence();
            return;
        }
        if (trip.t_s === this.of) return;
        this.of = trip.t_s;
        if (!this.on || (trip.age_s ?? 0) > freshAge) return;
        if ("Notification" in window && Notification.permission === "granted")
            new Notification("shakerd has tripped", { body: trip.finding, tag: "shakerd-trip", requireInteraction: true });
        this.silence();
        const { audio } = this;
        if (audio) sound(audio);
        this.timer = window.setInterval(() => { if (this.audio) sound(this.audio); }, pause);
        this.show();
    }
}
