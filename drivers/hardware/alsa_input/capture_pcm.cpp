#include "drivers/hardware/alsa_input/capture_pcm.hpp"

#include <alsa/asoundlib.h>
#include <spdlog/fmt/fmt.h>
#include <spdlog/fmt/ranges.h>

#include <algorithm>

#include "drivers/errors.hpp"
#include "drivers/hardware/alsa/config.hpp"
#include "drivers/hardware/clock/host_now.hpp"

namespace shaker::alsa_input {

struct CapturePcm::State {
    std::string name;
    alsa::AlsaHandle handle;
    snd_pcm_t* pcm = static_cast<snd_pcm_t*>(handle.get());
    alsa::AlsaOwned<snd_pcm_status_t> status = alsa::made(snd_pcm_status_malloc, snd_pcm_status_free);
    std::string card{};
    std::string granted{};
    std::size_t frame_bytes = 0;
    int significant_bits = 0;
    bool monotonic = false;  // its stamps are CLOCK_MONOTONIC

    [[noreturn]] void refuse(const std::string& what) const {
        throw DeviceError{"ALSA input " + name + ": " + what};
    }
    void check(int error, const char* what) const {
        if (error < 0) refuse(std::string{what} + ": " + snd_strerror(error));
    }
    void agree(const InputSettings& settings);
    void set_software(int period_frames);
};

void CapturePcm::State::agree(const InputSettings& s) {
    const auto owned = alsa::made(snd_pcm_hw_params_malloc, snd_pcm_hw_params_free);
    snd_pcm_hw_params_t* hw = owned.get();
    check(snd_pcm_hw_params_any(pcm, hw), "has no configuration to record with");
    check(snd_pcm_hw_params_set_rate_resample(pcm, hw, 0), "resampling cannot be switched off");
    check(snd_pcm_hw_params_set_access(pcm, hw, SND_PCM_ACCESS_RW_INTERLEAVED), "interleaved reading");
    const auto format = static_cast<snd_pcm_format_t>(alsa::format_number(s.format));
    if (snd_pcm_hw_params_set_format(pcm, hw, format) < 0)
        refuse(
            fmt::format("format {} is not possible: {}", to_text(s.format), alsa::allowed_formats(pcm, hw)));
    if (snd_pcm_hw_params_set_rate(pcm, hw, static_cast<unsigned>(s.rate_hz), 0) < 0)
        refuse(fmt::format("rate_hz {} is not possible: {}", s.rate_hz, alsa::allowed_rates(pcm, hw)));
    const std::vector<int> counts = alsa::possible_channels(pcm, hw);
    const int needed = std::ranges::max(s.channels);
    const auto enough = std::ranges::lower_bound(counts, needed);
    if (enough == counts.end() || snd_pcm_hw_params_set_channels(pcm, hw, static_cast<unsigned>(*enough)) < 0)
        refuse(fmt::format("channel {} is not possible; the channel counts it has are {}", needed,
                           fmt::join(counts, ", ")));
    auto period = static_cast<snd_pcm_uframes_t>(s.period_frames),
         buffer = static_cast<snd_pcm_uframes_t>(s.buffer_frames);
    check(snd_pcm_hw_params_set_period_size_near(pcm, hw, &period, nullptr), "period_frames");
    check(snd_pcm_hw_params_set_buffer_size_near(pcm, hw, &buffer), "buffer_frames");
    check(snd_pcm_hw_params(pcm, hw), "the configuration is refused");
    // Samples that come in bursts come late, and a stop with them.
    const int most = s.block_samples() * s.reduce;
    if (period > static_cast<snd_pcm_uframes_t>(most) || buffer < 4 * period)
        refuse(
            fmt::format("periods of {} in a buffer of {} samples are the nearest to period_frames {} and "
                        "buffer_frames {}; allowed are periods of at most {}, and four of them in the buffer",
                        period, buffer, s.period_frames, s.buffer_frames, most));
    significant_bits = std::max(0, snd_pcm_hw_params_get_sbits(hw));
    unsigned rate = 0;
    snd_pcm_hw_params_get_rate(hw, &rate, nullptr);
    if (rate != static_cast<unsigned>(s.rate_hz))
        refuse(fmt::format("rate_hz {} was requested, {} granted", s.rate_hz, rate));
    frame_bytes = static_cast<std::size_t>(*enough) *
                  static_cast<std::size_t>(snd_pcm_format_physical_width(format)) / 8;
    granted = fmt::format("{}: {} at {} Hz, {} channels, period {}, buffer {} samples ({:.1f} ms)", name,
                          to_text(s.format), rate, *enough, period, buffer,
                          1e3 * duration_s(static_cast<std::int64_t>(buffer), rate));
    set_software(static_cast<int>(period));
}

// Started explicitly; a full buffer stops the stream, and the loss is then known.
void CapturePcm::State::set_software(int period_frames) {
    const auto owned = alsa::made(snd_pcm_sw_params_malloc, snd_pcm_sw_params_free);
    snd_pcm_sw_params_t* sw = owned.get();
    const char* what = "the software parameters";
    snd_pcm_uframes_t boundary = 0;
    check(snd_pcm_sw_params_current(pcm, sw), what);
    check(snd_pcm_sw_params_get_boundary(sw, &boundary), what);
    check(snd_pcm_sw_params_set_start_threshold(pcm, sw, boundary), what);
    check(snd_pcm_sw_params_set_avail_min(pcm, sw, static_cast<snd_pcm_uframes_t>(period_frames)), what);
    check(snd_pcm_sw_params_set_tstamp_mode(pcm, sw, SND_PCM_TSTAMP_ENABLE), what);
    snd_pcm_sw_params_set_tstamp_type(pcm, sw, SND_PCM_TSTAMP_TYPE_MONOTONIC);
    check(snd_pcm_sw_params(pcm, sw), what);
    snd_pcm_tstamp_type_t type{};
    check(snd_pcm_sw_params_get_tstamp_type(sw, &type), what);
    monotonic = type == SND_PCM_TSTAMP_TYPE_MONOTONIC;
}

CapturePcm::CapturePcm(const InputSettings& settings)
    : state_{new State{.name = settings.pcm,
                       .handle = open_alsa(alsa::Direction::capture, settings.pcm, settings.alsa_config)}} {
    state_->agree(settings);
    state_->card = alsa::card_name(state_->pcm);
}

CapturePcm::~CapturePcm() = default;

std::size_t CapturePcm::frame_bytes() const noexcept { return state_->frame_bytes; }
int CapturePcm::significant_bits() const noexcept { return state_->significant_bits; }
const std::string& CapturePcm::card() const noexcept { return state_->card; }
std::string CapturePcm::text() const { return state_->granted; }

int CapturePcm::start() noexcept {
    snd_pcm_drop(state_->pcm);
    if (const int error = snd_pcm_prepare(state_->pcm); error < 0) return error;
    return snd_pcm_start(state_->pcm);
}

std::int64_t CapturePcm::read(std::span<std::byte> room) noexcept {
    const snd_pcm_sframes_t n = snd_pcm_readi(state_->pcm, room.data(), room.size() / state_->frame_bytes);
    return n == -EAGAIN ? 0 : n;
}

int CapturePcm::waiting(Waiting& out) noexcept {
    if (const int error = snd_pcm_status(state_->pcm, state_->status.get()); error < 0) return error;
    snd_htimestamp_t stamp{};
    snd_pcm_status_get_htstamp(state_->status.get(), &stamp);
    out.frames = static_cast<std::int64_t>(snd_pcm_status_get_avail(state_->status.get()));
    // A stream that has just started may have no stamp.
    const bool stamped = state_->monotonic && (stamp.tv_sec != 0 || stamp.tv_nsec != 0);
    out.at = stamped ? hardware::host_time(stamp) : hardware::host_now();
    return 0;
}

void CapturePcm::wait(std::chrono::milliseconds at_most) noexcept {
    static_cast<void>(snd_pcm_wait(state_->pcm, static_cast<int>(at_most.count())));
}

}  // namespace shaker::alsa_input
