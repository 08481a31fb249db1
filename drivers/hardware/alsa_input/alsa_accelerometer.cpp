#include "drivers/hardware/alsa_input/alsa_accelerometer.hpp"

#include <alsa/asoundlib.h>
#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <atomic>
#include <bit>
#include <cerrno>
#include <cmath>
#include <limits>
#include <thread>
#include <utility>

#include "drivers/errors.hpp"
#include "drivers/hardware/alsa_input/capture_pcm.hpp"
#include "drivers/hardware/alsa_input/rate_reducer.hpp"
#include "drivers/hardware/clock/host_now.hpp"

namespace shaker::alsa_input {

namespace {

using std::chrono::milliseconds;
constexpr milliseconds reopen_pause{500};
constexpr int most_empty_starts = 5;
constexpr double full_count = 2147483648.0;  // of full scale

std::size_t bytes_of(alsa::SampleFormat format) noexcept {
    return format == alsa::SampleFormat::s16 ? 2 : format == alsa::SampleFormat::s24_3 ? 3 : 4;
}

// No converter has more than 24 bits. significant: of the converter; 0: unknown.
std::int64_t largest_code(alsa::SampleFormat format, int significant) noexcept {
    constexpr std::int64_t top = std::int64_t{1} << 31;
    constexpr int bits_of_16 = 16, most_bits = 24, container = 32;
    const int most = format == alsa::SampleFormat::s16 ? bits_of_16 : most_bits;
    return top - (std::int64_t{1} << (container - (significant > 0 ? std::min(most, significant) : most)));
}

bool same(const std::optional<UsbSensor>& a, const std::optional<UsbSensor>& b) {
    return a.has_value() == b.has_value() && (!a || (a->model == b->model && a->serial == b->serial));
}

class AlsaAccelerometer final : public Accelerometer {
public:
    AlsaAccelerometer(const InputSettings& settings, hardware::Notes& notes)
        : settings_{settings}, pcm_{std::make_unique<CapturePcm>(settings)}, reducer_{settings.reduce} {
        usb_ = usb_sensor(pcm_->card());
        const double full = settings.full_scale_mps2(usb_, 0);
        largest_ = largest_code(settings.format, pcm_->significant_bits());
        const double clips = full * static_cast<double>(largest_) / full_count;
        notes.push_back(pcm_->text());
        if (usb_)
            notes.push_back(
                fmt::format("{}, serial number {}, calibrated {}", usb_->model, usb_->serial, usb_->date));
        notes.push_back(fmt::format("full scale is {:.4g} m/s^2; {:.6g} samples/s of {} axes", full,
                                    settings.sensor_rate_hz(), settings.axes()));
        info_ = {.name = "input " + settings.pcm,
                 .rate_hz = settings.sensor_rate_hz(),
                 .axes = settings.axes(),
                 .gravity = settings.gravity,
                 .response = settings.response,
                 .dac_clock = settings.dac_clock,
                 .mps2_per_count = {},
                 .clock_uncertainty_s = settings.clock_uncertainty_s,
                 .range_mps2 = std::min(settings.range_mps2.value_or(clips), clips),
                 .block_s = settings.block_samples() / settings.sensor_rate_hz(),
                 .shaker_axis = settings.shaker_axis};
        for (std::size_t k = 0; k < settings.channels.size(); ++k)
            info_.mps2_per_count[k] = settings.full_scale_mps2(usb_, k) / full_count;
        frames_.resize(static_cast<std::size_t>(settings.period_frames) * pcm_->frame_bytes());
    }

    [[nodiscard]] AccelerometerInfo info() const override { return info_; }
    [[nodiscard]] DeviceCounts counts() const noexcept override {
        return {.taken = taken_, .lost = lost_, .incidents = incidents_, .reopened = reopened_};
    }
    bool read(AccelBlock& block, milliseconds wait) override;
    [[nodiscard]] bool ended() const noexcept override { return stopped_; }
    void stop() noexcept override { stopped_ = true; }

private:
    bool take_frames(AccelBlock& block) noexcept;
    bool take_frame(const std::byte* frame) noexcept;
    void hand_over(AccelBlock& block) noexcept;
    bool fetch();
    void recover(int error);
    int place() noexcept;
    [[nodiscard]] HostTime time_of(std::int64_t index) const noexcept {
        return newest_ + std::chrono::duration_cast<std::chrono::nanoseconds>(
                             Seconds{duration_s(index - newest_index_, settings_.rate_hz)});
    }

    const InputSettings settings_;
    std::unique_ptr<CapturePcm> pcm_;  // null: closed
    RateReducer reducer_;
    AccelerometerInfo info_{};
    std::vector<std::byte> frames_{};
    std::size_t at_ = 0, end_ = 0;   // bytes of frames_ that wait
    std::int64_t next_ = 0;          // index of the next frame: samples of the card since the start
    std::int64_t from_ = 0;          // index of the stream's first frame
    std::int64_t next_tick_ = 0;     // of the sensor, without a gap
    std::int64_t newest_index_ = 0;  // frame captured at newest_
    HostTime newest_{};
    bool placed_ = true;  // the stream's place among the indices is known
    bool gap_ = false;    // samples are missing before the next one
    AccelBlock block_{.first = {}, .arrived = {}, .size = 0};
    std::optional<UsbSensor> usb_{};
    std::int64_t largest_ = 0;         // code at or beyond which a sample is clipped
    std::int64_t clipped_until_ = -1;  // index of the last frame whose filter sees a clipped one
    int empty_starts_ = 0;             // of the stream, without frames since
    HostTime last_data_{}, opened_{};
    int trouble_ = 0;  // the newest error
    std::atomic<std::uint64_t> taken_{0}, lost_{0}, incidents_{0}, reopened_{0};
    std::atomic<bool> stopped_ = false;
};

void AlsaAccelerometer::hand_over(AccelBlock& block) noexcept {
    block = block_;
    block.arrived = time_of((block_.first.n + block_.size - 1) * settings_.reduce + reducer_.delay());
    taken_ += static_cast<std::uint64_t>(block_.size);
    block_ = {.first = {}, .arrived = {}, .size = 0};
}

// True when the block is full.
bool AlsaAccelerometer::take_frame(const std::byte* frame) noexcept {
    const std::size_t bytes = bytes_of(settings_.format);
    std::array<double, 3> sample{};
    bool clipped = false;
    for (std::size_t k = 0; k < settings_.channels.size(); ++k) {
        const std::int32_t code =
            code_at(frame + bytes * static_cast<std::size_t>(settings_.channels[k] - 1), settings_.format);
        clipped = clipped || std::abs(std::int64_t{code}) >= largest_;
        sample[k] = code;
    }
    reducer_.add(sample);
    const std::int64_t index = next_++, warm = 2 * reducer_.delay();  // samples until the filter is full
    if (clipped) clipped_until_ = index + warm;
    if (index <= clipped_until_) block_.quality = block_.quality | Quality::clipped;
    if (index - from_ < warm || (index - warm) % settings_.reduce != 0) return false;
    const AccelTick tick{(index - warm) / settings_.reduce};
    if (block_.size == 0) {
        block_.first = tick;
        if (std::exchange(gap_, false)) {
            block_.quality = block_.quality | Quality::gap;
            lost_ += static_cast<std::uint64_t>(tick.n - next_tick_);
        }
    }
    next_tick_ = tick.n + 1;
    auto& counts = block_.counts[static_cast<std::size_t>(block_.size++)];
    const std::array<double, 3> value = reducer_.value();
    constexpr double most = std::numeric_limits<std::int32_t>::max();
    for (std::size_t k = 0; k < settings_.channels.size(); ++k)
        counts[k] = static_cast<std::int32_t>(std::lround(std::clamp(value[k], -most, most)));
    return block_.size == settings_.block_samples();
}

bool AlsaAccelerometer::take_frames(AccelBlock& block) noexcept {
    while (at_ < end_) {
        const std::byte* frame = frames_.data() + at_;
        at_ += pcm_->frame_bytes();
        if (!take_frame(frame)) continue;
        hand_over(block);
        return true;
    }
    return false;
}

// The place of a stream that has started again, by the time of its newest frame.
int AlsaAccelerometer::place() noexcept {
    CapturePcm::Waiting waiting;
    if (const int error = pcm_->waiting(waiting); error < 0) return error;
    const auto read = static_cast<std::int64_t>(end_ / pcm_->frame_bytes());
    if (!placed_) {
        const double since_s = Seconds{waiting.at - newest_}.count();
        const auto newest = newest_index_ + std::llround(since_s * settings_.rate_hz);
        const std::int64_t first = std::max<std::int64_t>(newest - waiting.frames - read + 1, next_);
        next_ = from_ = first;
        placed_ = true;
        gap_ = true;
    }
    newest_index_ = next_ + read + waiting.frames - 1;
    newest_ = waiting.at;
    return 0;
}

// True when frames were read.
bool AlsaAccelerometer::fetch() {
    const std::int64_t n = pcm_->read(frames_);
    if (n < 0) recover(static_cast<int>(n));
    if (n <= 0) return false;
    at_ = 0;
    end_ = static_cast<std::size_t>(n) * pcm_->frame_bytes();
    if (const int error = place(); error < 0) {  // nobody knows when they were taken
        at_ = end_ = 0;
        recover(error);
        return false;
    }
    last_data_ = hardware::host_now();
    empty_starts_ = 0;
    return true;
}

void AlsaAccelerometer::recover(int error) {
    trouble_ = error;
    ++incidents_;
    placed_ = false;
    const bool passes = error == -EPIPE || error == -ESTRPIPE;
    if (passes && ++empty_starts_ < most_empty_starts && pcm_->start() >= 0) return;
    empty_starts_ = 0;
    pcm_.reset();
    opened_ = hardware::host_now();
}

bool AlsaAccelerometer::read(AccelBlock& block, milliseconds wait) {
    const HostTime until = hardware::host_now() + wait;
    if (last_data_ == HostTime{}) {  // first: what came while other devices were opened does not count
        last_data_ = hardware::host_now();
        if (const int error = pcm_->start(); error < 0)
            throw DeviceError{"ALSA input " + settings_.pcm + ": cannot be started: " + snd_strerror(error)};
    }
    while (!stopped_) {
        if (take_frames(block)) return true;
        if (pcm_ && fetch()) continue;
        if (!placed_ && block_.size > 0) {  // what was before the gap
            hand_over(block);
            return true;
        }
        const HostTime now = hardware::host_now();
        if (Seconds{now - last_data_}.count() > settings_.give_up_s)
            throw DeviceError{fmt::format("ALSA input {}: no samples for {} s: {}", settings_.pcm,
                                          settings_.give_up_s,
                                          trouble_ < 0 ? snd_strerror(trouble_) : "the card delivers none")};
        if (!pcm_ && now - opened_ > reopen_pause) {
            opened_ = now;
            try {
                auto fresh = std::make_unique<CapturePcm>(settings_);
                if (same(usb_, usb_sensor(fresh->card())) && fresh->start() >= 0) {
                    pcm_ = std::move(fresh);
                    ++reopened_;
                }
            } catch (const DeviceError&) {
                // It is tried again until give_up_s has passed.
            }
        }
        if (now >= until) return false;
        const auto left = std::chrono::duration_cast<milliseconds>(until - now) + milliseconds{1};
        if (pcm_)
            pcm_->wait(left);
        else
            std::this_thread::sleep_for(std::min(left, reopen_pause));
    }
    return false;
}

}  // namespace

std::int32_t code_at(const std::byte* at, alsa::SampleFormat format) noexcept {
    const std::size_t bytes = bytes_of(format);
    std::uint32_t code = 0;
    for (std::size_t i = 0; i < bytes; ++i) code |= std::to_integer<std::uint32_t>(at[i]) << (8 * i);
    const int left = format == alsa::SampleFormat::s16 ? 16 : format == alsa::SampleFormat::s32 ? 0 : 8;
    return std::bit_cast<std::int32_t>(code << left);
}

std::unique_ptr<Accelerometer> open_alsa_accelerometer(const InputSettings& settings,
                                                       hardware::Notes& notes) {
    return std::make_unique<AlsaAccelerometer>(settings, notes);
}

}  // namespace shaker::alsa_input
