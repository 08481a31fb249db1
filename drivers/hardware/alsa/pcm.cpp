#include "drivers/hardware/alsa/pcm.hpp"

#include <alsa/asoundlib.h>
#include <poll.h>
#include <spdlog/fmt/fmt.h>
#include <spdlog/fmt/ranges.h>

#include <algorithm>
#include <optional>
#include <vector>

#include "drivers/errors.hpp"
#include "drivers/hardware/alsa/config.hpp"
#include "drivers/hardware/alsa/stream_keeper.hpp"
#include "drivers/hardware/clock/host_now.hpp"

namespace shaker::alsa {

std::string AlsaGranted::text() const {
    const double begins_ms = 1e3 * kept_frames / rate_hz;
    return fmt::format(
        "{}: {} at {} Hz, {} channels, period {}, buffer {} samples ({:.1f} ms); {}; stamps {}", pcm,
        to_text(format), rate_hz, channels, period_frames, buffer_frames, 1e3 * buffer_frames / rate_hz,
        queue_frames < buffer_frames
            ? fmt::format(
                  "a ramp to zero is queued behind the drive; a hard stop takes the queue back, and its "
                  "ramp begins at most {:.1f} ms after that",
                  begins_ms)
            : fmt::format("{}: if the process stops, silence follows its last samples without a ramp; a hard "
                          "stop begins behind the queued drive, up to {:.1f} ms later",
                          rewinds ? "ramp_s is 0" : "frames cannot be taken back", begins_ms),
        monotonic ? "CLOCK_MONOTONIC" : "of an unknown clock, the host's clock is used");
}

struct AlsaPcm::State {
    AlsaGranted granted{};
    AlsaHandle handle;
    snd_pcm_t* pcm = static_cast<snd_pcm_t*>(handle.get());
    AlsaOwned<snd_pcm_status_t> status = made(snd_pcm_status_malloc, snd_pcm_status_free);
    std::optional<StreamKeeper> controller{};  // destroyed before the handle is closed
    std::vector<pollfd> polled{};
    std::vector<std::byte> silence{};
    std::size_t frame_bytes = 0;

    [[noreturn]] void refuse(const std::string& what) const {
        throw DeviceError{"ALSA device " + granted.pcm + ": " + what};
    }
    void check(int error, const char* what) const {
        if (error < 0) refuse(std::string{what} + ": " + snd_strerror(error));
    }
    void agree(const AlsaSettings& settings);
    void agree_frames(snd_pcm_hw_params_t* hw, const AlsaSettings& settings);
    void set_software(int stop_threshold);
    bool takes_back();
    void keep_open();
    [[nodiscard]] int stream_error() const noexcept;
};

// Requests exactly the settings: a device that would grant a near value is refused.
void AlsaPcm::State::agree(const AlsaSettings& settings) {
    const auto owned = made(snd_pcm_hw_params_malloc, snd_pcm_hw_params_free);
    snd_pcm_hw_params_t* hw = owned.get();
    const auto rate = static_cast<unsigned>(settings.rate_hz);
    const auto format = static_cast<snd_pcm_format_t>(format_number(settings.format));
    check(snd_pcm_hw_params_any(pcm, hw), "has no configuration to play with");
    check(snd_pcm_hw_params_set_rate_resample(pcm, hw, 0), "resampling cannot be switched off");
    check(snd_pcm_hw_params_set_access(pcm, hw, SND_PCM_ACCESS_RW_INTERLEAVED), "interleaved writing");
    if (snd_pcm_hw_params_set_format(pcm, hw, format) < 0)
        refuse(
            fmt::format("format {} is not possible: {}", to_text(settings.format), allowed_formats(pcm, hw)));
    if (snd_pcm_hw_params_set_rate(pcm, hw, rate, 0) < 0)
        refuse(fmt::format("rate_hz {} is not possible: {}", rate, allowed_rates(pcm, hw)));
    const std::vector<int> counts = possible_channels(pcm, hw);
    const int needed = settings.channels();
    const auto enough = std::ranges::lower_bound(counts, needed);  // the others are silent
    const auto channels = static_cast<unsigned>(enough == counts.end() ? needed : *enough);
    if (snd_pcm_hw_params_set_channels(pcm, hw, channels) < 0)
        refuse(fmt::format("{}; the channel counts it has are {}",
                           needed > 2 ? fmt::format("{} {} is not possible",
                                                    needed == settings.enable_channel  ? "enable_channel"
                                                    : needed == settings.drive_channel ? "drive_channel"
                                                                                       : "trigger_channel",
                                                    needed)
                                      : "two channels are required",
                           fmt::join(counts, ", ")));
    agree_frames(hw, settings);
    check(snd_pcm_hw_params(pcm, hw), "the configuration is refused");

    snd_pcm_uframes_t period = 0, buffer = 0;
    unsigned granted_rate = 0;
    snd_pcm_hw_params_get_rate(hw, &granted_rate, nullptr);
    snd_pcm_hw_params_get_period_size(hw, &period, nullptr);
    snd_pcm_hw_params_get_buffer_size(hw, &buffer);
    granted.format = settings.format;
    granted.rate_hz = static_cast<int>(granted_rate);
    granted.channels = static_cast<int>(channels);
    granted.significant_bits = std::max(0, snd_pcm_hw_params_get_sbits(hw));
    granted.period_frames = static_cast<int>(period);
    granted.buffer_frames = static_cast<int>(buffer);
    if (granted_rate != rate || granted.period_frames != settings.period_frames ||
        granted.buffer_frames != settings.buffer_frames)
        refuse(
            fmt::format("rate_hz {}, period_frames {}, buffer_frames {} were requested, {}, {}, {} granted",
                        rate, settings.period_frames, settings.buffer_frames, granted_rate, period, buffer));
    frame_bytes = channels * static_cast<std::size_t>(snd_pcm_format_physical_width(format)) / 8;
}

void AlsaPcm::State::agree_frames(snd_pcm_hw_params_t* hw, const AlsaSettings& settings) {
    snd_pcm_uframes_t least = 0, most = 0;
    snd_pcm_hw_params_get_period_size_min(hw, &least, nullptr);
    snd_pcm_hw_params_get_period_size_max(hw, &most, nullptr);
    const auto period = static_cast<snd_pcm_uframes_t>(settings.period_frames);
    const auto buffer = static_cast<snd_pcm_uframes_t>(settings.buffer_frames);
    if (snd_pcm_hw_params_set_period_size(pcm, hw, period, 0) < 0)
        refuse(fmt::format("period_frames {} is not possible: must be {} to {}", period, least, most));
    snd_pcm_hw_params_get_buffer_size_min(hw, &least);
    snd_pcm_hw_params_get_buffer_size_max(hw, &most);
    if (snd_pcm_hw_params_set_buffer_size(pcm, hw, buffer) < 0)
        refuse(fmt::format(
            "buffer_frames {} is not possible with periods of {}: must be {} to {}, as a rule whole "
            "periods",
            buffer, period, least, most));
}

// The stream is started explicitly and stops when `stop_threshold` frames are free. Played frames become
// silence, so that old frames are never heard again.
void AlsaPcm::State::set_software(int stop_threshold) {
    const auto owned = made(snd_pcm_sw_params_malloc, snd_pcm_sw_params_free);
    snd_pcm_sw_params_t* sw = owned.get();
    snd_pcm_uframes_t boundary = 0;
    const char* what = "the software parameters";
    check(snd_pcm_sw_params_current(pcm, sw), what);
    check(snd_pcm_sw_params_get_boundary(sw, &boundary), what);
    check(snd_pcm_sw_params_set_start_threshold(pcm, sw, boundary), what);
    check(snd_pcm_sw_params_set_stop_threshold(pcm, sw, static_cast<snd_pcm_uframes_t>(stop_threshold)),
          what);
    check(snd_pcm_sw_params_set_silence_threshold(pcm, sw, 0), what);
    check(snd_pcm_sw_params_set_silence_size(pcm, sw, boundary), what);
    check(snd_pcm_sw_params_set_avail_min(pcm, sw, static_cast<snd_pcm_uframes_t>(granted.period_frames)),
          what);
    check(snd_pcm_sw_params_set_tstamp_mode(pcm, sw, SND_PCM_TSTAMP_ENABLE), what);
    snd_pcm_sw_params_set_tstamp_type(pcm, sw, SND_PCM_TSTAMP_TYPE_MONOTONIC);
    check(snd_pcm_sw_params(pcm, sw), what);
    snd_pcm_tstamp_type_t type{};
    check(snd_pcm_sw_params_get_tstamp_type(sw, &type), what);
    granted.monotonic = type == SND_PCM_TSTAMP_TYPE_MONOTONIC;
    granted.stop_threshold = stop_threshold;
}

// Writes a period of silence and takes it back in steps. The kernel's PCMs report correctly how many frames
// were taken back; for others libasound moves only its own pointer and reports "all", so each step must show
// in their delay. (Not in snd_pcm_status: its delay is libasound's pointer when the device has none.)
bool AlsaPcm::State::takes_back() {
    constexpr int steps = 4;
    const snd_pcm_sframes_t step = granted.period_frames / steps;
    check(snd_pcm_prepare(pcm), "cannot be made ready to play");
    const auto written = snd_pcm_writei(pcm, silence.data(), static_cast<snd_pcm_uframes_t>(steps * step));
    if (written < 0) check(static_cast<int>(written), "does not take samples");
    const bool kernel = snd_pcm_type(pcm) == SND_PCM_TYPE_HW;
    bool back = true;
    for (int left = steps - 1; back && left >= 0; --left) {
        snd_pcm_sframes_t delay = 0;
        back = snd_pcm_rewind(pcm, static_cast<snd_pcm_uframes_t>(step)) == step &&
               (kernel || (snd_pcm_delay(pcm, &delay) == 0 && delay == left * step));
    }
    back = back && snd_pcm_avail(pcm) == granted.buffer_frames;
    snd_pcm_drop(pcm);
    return back;
}

// Keeps a kernel stream open after the death of this process until it stops by its threshold, with a margin.
void AlsaPcm::State::keep_open() {
    constexpr double margin_s = 0.05;
    check(snd_pcm_poll_descriptors(pcm, polled.data(), 1), "cannot be waited for");
    controller.emplace(polled.front().fd, Seconds{margin_s + static_cast<double>(granted.stop_threshold) /
                                                                 static_cast<double>(granted.rate_hz)});
}

int AlsaPcm::State::stream_error() const noexcept {
    switch (snd_pcm_state(pcm)) {
        case SND_PCM_STATE_XRUN:
            return -EPIPE;
        case SND_PCM_STATE_SUSPENDED:
            return -ESTRPIPE;
        case SND_PCM_STATE_DISCONNECTED:
            return -ENODEV;
        case SND_PCM_STATE_OPEN:
        case SND_PCM_STATE_SETUP:
            return -EBADFD;
        default:
            return 0;
    }
}

AlsaPcm::AlsaPcm(const AlsaSettings& settings)
    : state_{new State{.handle = open_alsa(Direction::playback, settings.pcm, settings.alsa_config)}} {
    State& s = *state_;
    s.granted.pcm = settings.pcm;
    s.agree(settings);
    s.silence.resize(static_cast<std::size_t>(s.granted.buffer_frames) * s.frame_bytes);
    s.set_software(s.granted.buffer_frames);
    s.granted.rewinds = s.takes_back();
    constexpr int kept_periods = 2;
    const int ramp = s.granted.rewinds ? settings.ramp_frames() : 0;
    s.granted.queue_frames = s.granted.buffer_frames - ramp;
    s.granted.kept_frames = ramp > 0
                                ? std::min(kept_periods * s.granted.period_frames, s.granted.queue_frames)
                                : s.granted.queue_frames;
    // While frames are taken back and not replaced yet, the application's end is before a ramp that is still
    // in the ring, behind as much of the drive as was taken back. If the process dies then, playback must
    // continue to the end of that ramp.
    if (s.granted.rewinds)
        s.set_software(s.granted.buffer_frames + ramp + s.granted.queue_frames - s.granted.kept_frames);
    const int count = snd_pcm_poll_descriptors_count(s.pcm);
    s.check(count, "cannot be waited for");
    s.polled.resize(static_cast<std::size_t>(count) + 1);
    const snd_pcm_type_t type = snd_pcm_type(s.pcm);  // a plug-in of the mock bench stops with its file, too
    if (s.granted.rewinds && (type == SND_PCM_TYPE_HW || type == SND_PCM_TYPE_IOPLUG)) s.keep_open();
}

AlsaPcm::~AlsaPcm() = default;

const AlsaGranted& AlsaPcm::granted() const noexcept { return state_->granted; }

AlsaPcm::Queued AlsaPcm::queued() noexcept {
    const snd_pcm_sframes_t room = snd_pcm_avail(state_->pcm);
    if (room < 0) return {static_cast<int>(room), 0};
    return {state_->stream_error(), state_->granted.buffer_frames - room};
}

int AlsaPcm::prepare() noexcept {
    snd_pcm_drop(state_->pcm);
    return snd_pcm_prepare(state_->pcm);
}

int AlsaPcm::start() noexcept { return snd_pcm_start(state_->pcm); }

std::int64_t AlsaPcm::write(std::span<const std::byte> frames) noexcept {
    return snd_pcm_writei(state_->pcm, frames.data(), frames.size() / state_->frame_bytes);
}

std::int64_t AlsaPcm::write_silence(std::int64_t frames) noexcept {
    return snd_pcm_writei(state_->pcm, state_->silence.data(), static_cast<snd_pcm_uframes_t>(frames));
}

std::int64_t AlsaPcm::rewind(std::int64_t frames, std::int64_t least) noexcept {
    const snd_pcm_sframes_t back = snd_pcm_rewind(state_->pcm, static_cast<snd_pcm_uframes_t>(frames));
    const Queued left = queued();
    if (back == frames && left.error == 0 && left.frames >= least) return left.frames;
    if (back > 0) snd_pcm_forward(state_->pcm, static_cast<snd_pcm_uframes_t>(back));
    return -1;
}

std::int64_t AlsaPcm::rewindable() noexcept {
    return std::max<snd_pcm_sframes_t>(0, snd_pcm_rewindable(state_->pcm));
}

int AlsaPcm::delay(AlsaDelay& out) noexcept {
    if (const int error = snd_pcm_status(state_->pcm, state_->status.get()); error < 0) return error;
    if (const int error = state_->stream_error(); error != 0) return error;
    snd_htimestamp_t stamp{};
    snd_pcm_status_get_htstamp(state_->status.get(), &stamp);
    out.frames = snd_pcm_status_get_delay(state_->status.get());
    // A stream that has just started may have no stamp. The host's clock, read after it, is then slightly
    // late.
    const bool stamped = state_->granted.monotonic && (stamp.tv_sec != 0 || stamp.tv_nsec != 0);
    out.at = stamped ? hardware::host_time(stamp) : hardware::host_now();
    return 0;
}

int AlsaPcm::wait(int wake_fd, std::chrono::nanoseconds at_most) noexcept {
    State& s = *state_;
    const auto count = static_cast<unsigned>(s.polled.size() - 1);
    const int filled = snd_pcm_poll_descriptors(s.pcm, s.polled.data(), count);
    if (filled < 0) return filled;
    s.polled[count] = {.fd = wake_fd, .events = POLLIN, .revents = 0};
    const auto ns = std::max<std::int64_t>(0, at_most.count());
    const timespec limit{.tv_sec = ns / 1'000'000'000, .tv_nsec = ns % 1'000'000'000};
    if (::ppoll(s.polled.data(), s.polled.size(), &limit, nullptr) <= 0) return 0;
    unsigned short events = 0;
    const int error = snd_pcm_poll_descriptors_revents(s.pcm, s.polled.data(), count, &events);
    if (error < 0) return error;
    if ((events & (POLLERR | POLLNVAL | POLLHUP)) == 0) return 0;
    const int broken = queued().error;  // makes libasound update the state of the stream
    return broken != 0 ? broken : -EIO;
}

void AlsaPcm::drop() noexcept { snd_pcm_drop(state_->pcm); }

void AlsaPcm::fail(const std::string& what, int error) const {
    state_->refuse(what + ": " + snd_strerror(error));
}

}  // namespace shaker::alsa
