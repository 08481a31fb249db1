// The page's only animation loop. Nothing is drawn while the page is hidden, and no element that is out of view.

interface Entry {
    draw: (now: number) => void;
    pause: number;  // ms between two calls
    last: number;
    element: Element | null;
    failed: boolean;
}

export class Loop {
    private readonly entries: Entry[] = [];
    private readonly inView = new Map<Element, boolean>();
    private readonly observer = new IntersectionObserver((changes) => {
        for (const change of changes) this.inView.set(change.target, change.isIntersecting);
    }, { rootMargin: "100px" });

    /** Calls `draw` at most `rate` times per second; with an element only while the element is in view. */
    add(draw: (now: number) => void, rate: number, element?: Element): void {
        this.entries.push({ draw, pause: 1000 / rate, last: -Infinity, element: element ?? null, failed: false });
        if (element) this.observer.observe(element);
    }

    start(): void {
        const turn = (now: number): void => {
            requestAnimationFrame(turn);
            if (document.hidden) return;
            for (const entry of this.entries)
                if (now - entry.last >= entry.pause - 4 && (!entry.element || this.isVisible(entry.element))) run(entry, now);
        };
        requestAnimationFrame(turn);
    }

    isVisible(element: Element): boolean { return this.inView.get(element) ?? false; }
}

/** An exception of one view must not stop the other views, above all state and trip. */
function run(entry: Entry, now: number): void {
    entry.last = now;
    try {
        entry.draw(now);
    } catch (error) {
        if (!entry.failed) console.error(error);
        entry.failed = true;
    }
}
