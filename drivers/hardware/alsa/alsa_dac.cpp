#include "drivers/hardware/alsa/alsa_dac.hpp"

#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstdint>
#include <ctime>
#include <limits>
#include <utility>

#include "drivers/data.hpp"
#include "drivers/descriptor.hpp"
#include "drivers/errors.hpp"
#include "drivers/hardware/alsa/output_frames.hpp"
#include "drivers/hardware/clock/host_now.hpp"

namespace shaker::alsa {

namespace {

/// Position of a DAC on its sample counter, from its reports, and detection of stops. Real-time.
class PlayingClock {
public:
    explicit PlayingClock(double nominal_hz) noexcept : rate_hz_{nominal_hz} {}

    /// The first report of a stream. The rate measured before is kept.
    void begin(const PlayTime& seen) noexcept { anchor_ = last_ = reference_ = seen; }

    /// A further report. Returns the number of samples by which playback lags behind the earliest report of
    /// the last seconds; more than the device's granularity only when it had stopped.
    std::int64_t note(const PlayTime& seen) noexcept {
        const double since_anchor = seconds_between(anchor_, seen);
        if (since_anchor > worth_a_rate_s)
            rate_hz_ = static_cast<double>(seen.tick.n - anchor_.tick.n) / since_anchor;
        const std::int64_t behind = at(reference_, seen.heard) - seen.tick.n;
        if (behind <= 0 || seconds_between(reference_, seen) > reference_lasts_s) reference_ = seen;
        last_ = seen;
        return behind;
    }

    /// The sample playing at `t`, to a few samples.
    [[nodiscard]] std::int64_t tick_at(HostTime t) const noexcept { return at(last_, t); }

private:
    static constexpr double worth_a_rate_s = 2, reference_lasts_s = 2;

    static double seconds_between(const PlayTime& a, const PlayTime& b) noexcept {
        return Seconds{b.heard - a.heard}.count();
    }
    [[nodiscard]] std::int64_t at(const PlayTime& from, HostTime t) const noexcept {
        return from.tick.n + static_cast<std::int64_t>(rate_hz_ * Seconds{t - from.heard}.count());
    }

    double rate_hz_;
    PlayTime anchor_{}, last_{}, reference_{};
};

constexpr int recoveries_in_a_row = 3;
constexpr double least_slip_s = 0.01;
// A ramp that starts sooner than this is not replaced: replacing takes time too.
constexpr double margin_s = 5e-4;

// For devices that report their position in steps.
constexpr std::chrono::nanoseconds least_wait{250'000};

// Outcomes other than libasound's errors.
constexpr int done = 0, came_late = 1, was_stalled = 2, stop_requested = 3;

bool passes(int error) noexcept {
    return error == -EPIPE || error == -ESTRPIPE || error == -ETIMEDOUT || error == -EAGAIN;
}

}  // namespace

struct AlsaDac::State {
    AlsaSettings settings;
    std::unique_ptr<AlsaPcm> pcm;
    AlsaGranted granted = pcm->granted();
    OutputFrames frames;
    PlayingClock clock;
    Descriptor wake;  // readable after stop()
    std::atomic<bool> stopping = false;
    std::atomic<std::uint64_t> taken = 0, lost = 0, incidents = 0, reopened = 0;

    bool running = false;
    // Samples; ramp: queued behind the drive, 0 if frames cannot be taken back.
    std::int64_t buffer, ramp;
    std::int64_t margin, slip_limit;
    bool enabled = false;
    std::int64_t stuck = 0;  // samples of silence behind the ramp of a take-back that could not be taken back
    std::int64_t end = 0;    // tick after the last sample of the drive that was written
    std::int64_t driven = 0;  // samples of the drive written since the last silence
    PlayTime last{};
    std::int64_t confirmed = 0;  // sample that played at the last report before which nothing stood still
    std::int64_t slipped = 0;    // samples by which ticks lag behind time
    int recoveries = 0;          // since the last block played
    bool opened_anew = false;    // since the last block played

    explicit State(const AlsaSettings& s);
    State(const State&) = delete;
    State& operator=(const State&) = delete;
    ~State();

    int begin();
    int put(std::span<const double> volts, std::span<const double> trigger);
    int wait_until_queued(std::int64_t most, std::int64_t least);
    std::int64_t take_back(std::int64_t most) noexcept;
    int note_time();
    void go_on(int outcome, std::int64_t wanted_end);
    int fill_behind();
    int put_silence(std::int64_t samples);
    int restart(int error);
    void play_out() noexcept;
    [[nodiscard]] OutputFrames make_frames() const;
    [[nodiscard]] HostTime deadline() const noexcept {
        return hardware::host_now() + std::chrono::nanoseconds{2'000'000'000 * buffer / settings.rate_hz};
    }
};

OutputFrames AlsaDac::State::make_frames() const {
    const AlsaGranted& got = pcm->granted();
    return {settings, PcmCodec{got.format, got.significant_bits, settings.full_scale_V},
            static_cast<std::size_t>(got.channels), static_cast<std::size_t>(got.period_frames)};
}

AlsaDac::State::State(const AlsaSettings& s)
    : settings{s},
      pcm{std::make_unique<AlsaPcm>(s)},
      frames{make_frames()},
      clock{static_cast<double>(s.rate_hz)},
      wake{::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)},
      buffer{s.buffer_frames},
      ramp{pcm->granted().rewinds ? s.ramp_frames() : 0},
      margin{static_cast<std::int64_t>(margin_s * s.rate_hz)},
      slip_limit{std::max<std::int64_t>(2L * s.period_frames,
                                        static_cast<std::int64_t>(least_slip_s * s.rate_hz))} {}

AlsaDac::State::~State() { play_out(); }

// Starts the stream full of silence, so that the first block has the same latency as all others.
int AlsaDac::State::begin() {
    if (const int error = pcm->prepare(); error < 0) return error;
    driven = 0;
    const std::int64_t written = pcm->write_silence(buffer);
    if (written != buffer) return written < 0 ? static_cast<int>(written) : -EPIPE;
    if (const int error = pcm->start(); error < 0) return error;
    AlsaDelay delay{};
    if (const int error = pcm->delay(delay); error < 0) return error;
    if (running) end = clock.tick_at(delay.at) + delay.frames - ramp;
    running = true;
    last = {DacTick{end + ramp - delay.frames}, delay.at};
    confirmed = last.tick.n;
    clock.begin(last);
    return done;
}

// Waits until at most `most` frames are queued; reports "late" when fewer than `least` are.
int AlsaDac::State::wait_until_queued(std::int64_t most, std::int64_t least) {
    const HostTime until = deadline();
    for (;;) {
        const HostTime now = hardware::host_now();
        const AlsaPcm::Queued queued = pcm->queued();
        if (queued.error < 0) return queued.error;
        if (queued.frames < least) return came_late;
        if (queued.frames <= most) return done;
        if (stopping) return stop_requested;
        if (now >= until) return -ETIMEDOUT;
        // The device wakes this thread at its periods only, which may come up to a period after the room.
        const std::chrono::nanoseconds room{1'000'000'000 * (queued.frames - most) / settings.rate_hz};
        const auto at_most = std::min<std::chrono::nanoseconds>(until - now, std::max(room, least_wait));
        if (const int error = pcm->wait(wake, at_most); error < 0) return error;
    }
}

int AlsaDac::State::put(std::span<const double> volts, std::span<const double> trigger) {
    if (std::exchange(stuck, 0) > 0) return came_late;
    const auto n = static_cast<std::int64_t>(volts.size());
    const std::int64_t least = ramp > 0 ? ramp + margin : std::numeric_limits<std::int64_t>::min();
    if (const int outcome = wait_until_queued(buffer - n, least); outcome != done) return outcome;
    const auto bytes = frames.block(volts, trigger, {end}, enabled)
                           .first(static_cast<std::size_t>(n + ramp) * frames.frame_bytes());
    const HostTime before = hardware::host_now();
    std::int64_t left = 0;
    if (ramp > 0 && (left = pcm->rewind(ramp)) < 0) return came_late;
    const std::int64_t written = pcm->write(bytes);
    if (written != n + ramp) return written < 0 ? static_cast<int>(written) : -EPIPE;
    end += n;
    driven += n;
    taken += static_cast<std::uint64_t>(n);
    // True if the old ramp may have started while it was being replaced.
    if (ramp > 0 &&
        Seconds{hardware::host_now() - before}.count() * settings.rate_hz >= static_cast<double>(left))
        return came_late;
    return note_time();
}

// The samples that were taken back become silence, so that they are not heard behind the ramp if the process
// dies. If playback reaches the new end meanwhile, the next put() comes late; errors stay in the stream until
// then, too. Silence that the device does not take back counts as lost, and so does the next block: the ramp
// behind the drive has been played.
std::int64_t AlsaDac::State::take_back(std::int64_t most) noexcept {
    if (ramp == 0 || !running || stopping || stuck > 0) return 0;
    const AlsaPcm::Queued queued = pcm->queued();
    if (queued.error < 0) return 0;
    const std::int64_t kept = pcm->granted().kept_frames;
    const std::int64_t n =
        std::min({most, queued.frames - ramp - kept, pcm->rewindable() - ramp, driven, frames.most_back()});
    if (n <= 0 || pcm->rewind(n + ramp, kept / 2) < 0) return 0;  // less: this thread stood still meanwhile
    frames.go_back(n);
    end -= n;
    driven -= n;
    taken -= static_cast<std::uint64_t>(n);
    if (pcm->write(frames.ramp(n)) == ramp + n && pcm->rewind(n) < 0) {
        stuck = n;
        end += n;
        lost += static_cast<std::uint64_t>(n);
    }
    return n;
}

int AlsaDac::State::note_time() {
    AlsaDelay delay{};
    if (const int error = pcm->delay(delay); error < 0) return error;
    last = {DacTick{end + ramp - delay.frames}, delay.at};
    slipped = clock.note(last);
    if (slipped > slip_limit) return was_stalled;
    confirmed = last.tick.n;
    slipped = 0;
    recoveries = 0;
    opened_anew = false;
    return done;
}

// After an error: silence, from which the next block starts. `wanted_end`: tick at which the current block
// should have ended.
void AlsaDac::State::go_on(int outcome, std::int64_t wanted_end) {
    const std::int64_t end_of_drive = end;
    const bool stalled = outcome == was_stalled || outcome == -ETIMEDOUT;
    const std::int64_t unheard = stalled ? wanted_end - confirmed : 0;
    ++incidents;
    if (outcome > 0) outcome = fill_behind();
    frames.restart();
    while (outcome != stop_requested && (outcome != done || end <= wanted_end))
        outcome = outcome == done ? put_silence(wanted_end + 1 - end) : restart(outcome);
    if (outcome == stop_requested) return;
    last.lost = end - wanted_end;
    last.unheard = unheard;
    lost += static_cast<std::uint64_t>(end - end_of_drive);
}

// Plays the ramp and queues silence behind it in the same stream. Corrects the ticks when the stream had
// stopped.
int AlsaDac::State::fill_behind() {
    const auto tail = static_cast<std::int64_t>(frames.ramp_frames());
    const int outcome = wait_until_queued(std::min(buffer - tail, buffer / 2), margin);
    if (outcome != done) return outcome == came_late ? -EPIPE : outcome;
    if (ramp == 0 && tail > 0) {  // the device cannot take frames back: the ramp is written now
        if (pcm->write(frames.ramp()) != tail) return -EPIPE;
        end += tail;
    }
    const AlsaPcm::Queued queued = pcm->queued();
    if (queued.error < 0) return queued.error;
    const std::int64_t silence = buffer - queued.frames;
    if (pcm->write_silence(silence) != silence) return -EPIPE;
    driven = 0;
    end += silence + std::exchange(slipped, 0);
    AlsaDelay delay{};
    if (const int error = pcm->delay(delay); error < 0) return error;
    last = {DacTick{end + ramp - delay.frames}, delay.at};
    confirmed = last.tick.n;
    clock.begin(last);
    return done;
}

// Writes at most one period of silence behind the queued silence.
int AlsaDac::State::put_silence(std::int64_t samples) {
    const std::int64_t n = std::min<std::int64_t>(samples, settings.period_frames);
    if (const int outcome = wait_until_queued(buffer - n, margin); outcome != done)
        return outcome == came_late ? -EPIPE : outcome;
    if (pcm->write_silence(n) != n) return -EPIPE;
    end += n;
    return done;
}

int AlsaDac::State::restart(int error) {
    slipped = 0;
    while (error != done) {
        if (!passes(error)) pcm->fail("playback stopped", error);
        const AlsaPcm::Queued queued = pcm->queued();
        if (queued.error == 0 && queued.frames > ramp) {
            const auto unheard = static_cast<std::uint64_t>(std::min(queued.frames - ramp, driven));
            taken -= unheard;
            lost += unheard;
        }
        if (++recoveries > recoveries_in_a_row) {
            if (opened_anew) pcm->fail("no playback after it was opened again", error);
            opened_anew = true;
            recoveries = 1;
            pcm.reset();
            pcm = std::make_unique<AlsaPcm>(settings);
            ramp = pcm->granted().rewinds ? settings.ramp_frames() : 0;
            frames = make_frames();
            ++reopened;
        }
        error = begin();
    }
    return error;
}

// End of the device's life: plays the queued samples and the ramp, which is written if missing. Takes a
// bounded time.
void AlsaDac::State::play_out() noexcept {
    if (!running || pcm == nullptr) return;
    const HostTime until = deadline();
    const auto tail = static_cast<std::int64_t>(frames.ramp_frames());
    bool ramped = ramp > 0 || tail == 0;
    for (AlsaPcm::Queued queued = pcm->queued();
         queued.error == 0 && queued.frames > 0 && hardware::host_now() < until; queued = pcm->queued()) {
        if (!ramped && buffer - queued.frames >= tail) ramped = pcm->write(frames.ramp()) == tail;
        const timespec pause{.tv_sec = 0, .tv_nsec = 1'000'000};
        ::nanosleep(&pause, nullptr);
    }
    pcm->drop();
}

AlsaDac::AlsaDac(const AlsaSettings& settings) : state_{new State{settings}} {}
AlsaDac::~AlsaDac() = default;

DacInfo AlsaDac::info() const {
    const AlsaSettings& s = state_->settings;
    const AlsaGranted& got = state_->granted;
    return {.name = s.pcm,
            .rate_hz = static_cast<double>(s.rate_hz),
            .full_scale_V = s.full_scale_V,
            .queue_frames = got.queue_frames,
            .kept_frames = got.kept_frames,
            .ramp_frames = got.rewinds ? s.ramp_frames() : 0,
            .enable_before_s = s.enable_channel > 0 ? s.enable_before_s : 0,
            .pulse_hz = s.pulse_hz};
}

DeviceCounts AlsaDac::counts() const noexcept {
    const State& s = *state_;
    return {.taken = s.taken, .lost = s.lost, .incidents = s.incidents, .reopened = s.reopened};
}

const AlsaGranted& AlsaDac::granted() const noexcept { return state_->granted; }

PlayTime AlsaDac::write(std::span<const double> volts, std::span<const double> trigger) {
    State& s = *state_;
    if (volts.size() != trigger.size()) throw DeviceError{s.settings.pcm + ": channels of different length"};
    if (s.stopping) return s.last;
    s.last.lost = s.last.unheard = 0;
    int outcome = s.running ? done : s.begin();
    if (outcome != done) static_cast<void>(s.restart(outcome));
    const auto most = static_cast<std::size_t>(s.settings.period_frames);
    for (std::size_t at = 0; at < volts.size(); at += most) {
        const std::size_t n = std::min(most, volts.size() - at);
        const std::int64_t wanted_end = s.end - s.stuck + static_cast<std::int64_t>(volts.size() - at);
        outcome = s.put(volts.subspan(at, n), trigger.subspan(at, n));
        if (outcome == done) continue;
        if (outcome != stop_requested) s.go_on(outcome, wanted_end);
        break;
    }
    return s.last;
}

std::int64_t AlsaDac::take_back(std::int64_t most) noexcept { return state_->take_back(most); }

void AlsaDac::enable(bool on) noexcept { state_->enabled = on; }

void AlsaDac::stop() noexcept {
    state_->stopping = true;
    const std::uint64_t one = 1;
    static_cast<void>(!::write(state_->wake, &one, sizeof one));
}

}  // namespace shaker::alsa
