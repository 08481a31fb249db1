// The one animation frame loop. Nothing is drawn while the page is hidden or what would be drawn is out of view.

interface Entry {
    draw: (now: number) => void;
    pause: number;  // ms between two calls
    last: number;
    visible: boolean;
    failed: boolean;
}

export class Loop {
    private readonly entries: Entry[] = [];
    private readonly byElement = new Map<Element, Entry>();
    private readonly observer = new IntersectionObserver((changes) => {
        for (const change of changes) {
            const entry = this.byElement.get(change.target);
            if (entry) entry.visible = change.isIntersecting;
        }
    }, { rootMargin: "100px" });

    /** Calls `draw` at most `rate` times a second. With an element: only while that is in view. */
    add(draw: (now: number) => void, rate: number, element?: Element): void {
        const entry: Entry = { draw, pause: 1000 / rate, last: -Infinity, visible: !element, failed: false };
        this.entries.push(entry);
        if (!element) return;
        this.byElement.set(element, entry);
        this.observer.observe(element);
    }

    start(): void {
        const turn = (now: number): void => {
            requestAnimationFrame(turn);
            if (document.hidden) return;
            for (const entry of this.entries) if (entry.visible && now - entry.last >= entry.pause - 4) run(entry, now);
        };
        requestAnimationFrame(turn);
    }

    isVisible(element: Element): boolean { return this.byElement.get(element)?.visible ?? false; }
}

/** One view that fails must not take the others, or the state and the trip, with it. */
function run(entry: Entry, now: number): void {
    entry.last = now;
    try {
        entry.draw(now);
    } catch (error) {
        if (!entry.failed) console.error(error);
        entry.failed = true;
    }
}
