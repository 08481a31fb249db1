#include "drivers/hardware/iio/iio_accelerometer.hpp"

#include <poll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <mutex>
#include <optional>
#include <span>
#include <thread>
#include <utility>

#include "drivers/descriptor.hpp"
#include "drivers/errors.hpp"
#include "drivers/handover.hpp"
#include "drivers/hardware/clock/host_now.hpp"
#include "drivers/hardware/iio/accel_blocks.hpp"
#include "drivers/hardware/iio/context.hpp"
#include "drivers/hardware/iio/sample_grid.hpp"
#include "drivers/hardware/iio/stream.hpp"
#include "drivers/quantity.hpp"
#include "drivers/realtime.hpp"

namespace shaker::iio {
namespace {

using std::chrono::milliseconds;
constexpr milliseconds first_pause{20}, longest_pause{500};
constexpr milliseconds polite_wait{100};
// Largest plausible distance of a stamp of the host's clock from the arrival.
constexpr std::int64_t stamp_ahead_ns = 100'000'000, stamp_behind_ns = 10'000'000'000;

std::int64_t now_ns() noexcept { return hardware::host_now().time_since_epoch().count(); }
HostTime host_time(std::int64_t ns) noexcept { return HostTime{std::chrono::nanoseconds{ns}}; }

/// Wakes one thread in wait(); a wake-up before wait() is not lost. Does not lock.
class Doorbell {
public:
    Doorbell() : fd_{eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)} {
        if (fd_ < 0) throw DeviceError{"eventfd: " + iio_words(errno)};
    }
    void ring() const noexcept { eventfd_write(fd_, 1); }
    void wait(milliseconds at_most) const noexcept {
        pollfd bell{.fd = fd_, .events = POLLIN, .revents = 0};
        eventfd_t rings = 0;
        if (poll(&bell, 1, static_cast<int>(at_most.count())) > 0) eventfd_read(fd_, &rings);
    }

private:
    Descriptor fd_;
};

AccelBlocks::Limits limits_of(const IioFacts& facts, const std::optional<double>& range_mps2) {
    AccelBlocks::Limits limits;
    limits.fill(limits_of(IioFormat{}));  // of an axis that is not read, whose counts are 0
    for (std::size_t k = 0; k < facts.scan.used; ++k) {
        limits[k] = limits_of(facts.scan.axes[k].format);
        if (!range_mps2) continue;
        const double range_counts = std::abs(*range_mps2 / facts.mps2_per_count[k]);
        const double low = -range_counts - facts.offset_counts[k];
        const double high = range_counts - facts.offset_counts[k];
        limits[k][0] = std::max(limits[k][0], static_cast<std::int64_t>(std::max(std::floor(low), -1e10)));
        limits[k][1] = std::min(limits[k][1], static_cast<std::int64_t>(std::min(std::ceil(high), 1e10)));
    }
    return limits;
}

// Range on every axis for either sign: from the settings, or that of the format.
double range_of(const IioFacts& facts, const std::optional<double>& range_mps2) {
    if (range_mps2) return *range_mps2;
    double range = std::numeric_limits<double>::infinity();
    for (std::size_t k = 0; k < facts.scan.used; ++k)
        for (const std::int64_t count : limits_of(facts.scan.axes[k].format))
            range = std::min(range, std::abs((static_cast<double>(count) + facts.offset_counts[k]) *
                                             facts.mps2_per_count[k]));
    return range;
}

class IioAccelerometer final : public Accelerometer {
public:
    explicit IioAccelerometer(const IioSettings& settings)
        : settings_{settings},
          stream_{std::make_unique<IioStream>(settings)},
          facts_{stream_->facts()},
          grid_{facts_.rate_hz},
          blocks_{limits_of(facts_, settings.range_mps2), settings.buffer_samples} {
        stream_->start();
    }
    IioAccelerometer(const IioAccelerometer&) = delete;
    IioAccelerometer& operator=(const IioAccelerometer&) = delete;
    ~IioAccelerometer() override { stop(); }

    [[nodiscard]] const IioFacts& facts() const noexcept { return facts_; }
    [[nodiscard]] AccelerometerInfo info() const override {
        return {.name = facts_.name,
                .rate_hz = facts_.rate_hz,
                .axes = static_cast<int>(facts_.scan.used),
                .gravity = settings_.gravity,
                .response = settings_.response,
                .offset_counts = facts_.offset_counts,
                .mps2_per_count = facts_.mps2_per_count,
                .clock_uncertainty_s = settings_.clock_uncertainty_s,
                .range_mps2 = range_of(facts_, settings_.range_mps2),
                .block_s = settings_.buffer_samples / facts_.rate_hz,
                .shaker_axis = settings_.shaker_axis};
    }
    [[nodiscard]] DeviceCounts counts() const noexcept override {
        return {blocks_.taken(), blocks_.lost(), incidents_ + clock_steps_, reopened_};
    }
    std::size_t read_early(std::span<std::array<std::int32_t, 3>> counts) noexcept override;
    bool read(AccelBlock& block, milliseconds wait) override;
    [[nodiscard]] bool ended() const noexcept override { return stopping_ && drained_; }
    void stop() noexcept override;

private:
    void run() noexcept;
    [[nodiscard]] bool restarted() noexcept;
    [[nodiscard]] bool reconnected() noexcept;
    void exchange_stream(std::unique_ptr<IioStream> fresh) noexcept;
    void remember(const std::string& words) noexcept;
    void take(std::span<const std::byte> samples) noexcept;
    void place(const TimedSample& sample) noexcept;
    void add(const PlacedSample& placed) noexcept;
    [[noreturn]] void give_up();

    const IioSettings settings_;
    std::mutex mutex_{};  // guards the pointer stream_ and trouble_; never held while libiio waits
    std::unique_ptr<IioStream> stream_;
    std::string trouble_ = "the sensor delivers none";
    const IioFacts facts_;
    // the reader's thread
    SampleGrid grid_;
    std::int64_t next_tick_ = 0, last_arrived_ns_ = 0;  // used without stamps
    bool broken_ = false;                               // since the last sample
    // both threads
    AccelBlocks blocks_;
    Ring<std::array<std::int32_t, 3>> early_{8192};
    Doorbell bell_{}, stop_bell_{}, end_bell_{};
    std::atomic<std::int64_t> last_data_ns_{0};
    std::atomic<std::uint64_t> incidents_{0}, clock_steps_{0}, reopened_{0};
    std::atomic<bool> stopping_{false}, drained_{false}, reader_started_{false}, reader_ended_{false};
    std::jthread reader_{};
};

bool IioAccelerometer::read(AccelBlock& block, milliseconds wait) {
    if (!reader_.joinable() && !stopping_) {
        last_data_ns_ = now_ns();
        reader_started_ = true;
        reader_ = std::jthread{[this] { run(); }};
    }
    std::optional<AccelBlock> taken = blocks_.take();
    if (!taken && !stopping_ && wait.count() > 0) {
        bell_.wait(wait);
        taken = blocks_.take();
    }
    if (taken) {
        block = *taken;
        return true;
    }
    drained_ = stopping_.load();
    const bool silent = static_cast<double>(now_ns() - last_data_ns_) > 1e9 * settings_.give_up_s;
    if (silent && !stopping_) give_up();
    return false;
}

std::size_t IioAccelerometer::read_early(std::span<std::array<std::int32_t, 3>> counts) noexcept {
    std::size_t n = 0;
    for (; n < counts.size(); ++n) {
        const auto sample = early_.pop();
        if (!sample) break;
        counts[n] = *sample;
    }
    return n;
}

void IioAccelerometer::give_up() {
    const std::scoped_lock lock{mutex_};
    throw DeviceError{facts_.name + ": no samples for " + to_text(settings_.give_up_s) + " s: " + trouble_};
}

void IioAccelerometer::stop() noexcept {
    stopping_ = true;
    stop_bell_.ring();
    bell_.ring();
    // A running sensor ends the wait by itself; libiio prints an error when it is cancelled.
    if (reader_started_) end_bell_.wait(polite_wait);
    const std::scoped_lock lock{mutex_};
    if (stream_ && !reader_ended_) stream_->cancel();
}

void IioAccelerometer::run() noexcept {
    static_cast<void>(name_thread("iio reader"));
    milliseconds wait{0};
    bool connected = restarted();
    std::span<const std::byte> samples;
    while (!stopping_) {
        const int rc = connected ? stream_->refill(samples) : 0;
        if (connected && rc == 0) {
            take(samples);
            wait = milliseconds{0};
            continue;
        }
        if (connected && !stopping_) {
            ++incidents_;
            remember(iio_words(rc));
        }
        broken_ = true;
        stop_bell_.wait(wait);
        wait = std::clamp(2 * wait, first_pause, longest_pause);
        connected = !stopping_ && reconnected();
    }
    reader_ended_ = true;
    end_bell_.ring();
}

/// Samples buffered since the device was opened are old, and more may have been lost.
bool IioAccelerometer::restarted() noexcept try {
    stream_->start();
    return true;
} catch (const std::exception& e) {
    remember(e.what());
    return false;
}

bool IioAccelerometer::reconnected() noexcept try {
    exchange_stream(nullptr);
    auto fresh = std::make_unique<IioStream>(settings_);
    if (!fresh->facts().same_scale(facts_)) throw DeviceError{"it came back with a different scale or rate"};
    exchange_stream(std::move(fresh));
    stream_->start();
    ++reopened_;
    return true;
} catch (const std::exception& e) {
    remember(e.what());
    return false;
}

void IioAccelerometer::exchange_stream(std::unique_ptr<IioStream> fresh) noexcept {
    const std::scoped_lock lock{mutex_};
    stream_.swap(fresh);
    if (stopping_ && stream_) stream_->cancel();
}

void IioAccelerometer::remember(const std::string& words) noexcept {
    const std::scoped_lock lock{mutex_};
    trouble_ = words;
}

void IioAccelerometer::take(std::span<const std::byte> samples) noexcept {
    const std::int64_t now = now_ns();
    last_data_ns_ = now;
    const IioScan& scan = facts_.scan;
    for (std::size_t left = samples.size() / scan.size; left-- > 0; samples = samples.subspan(scan.size)) {
        TimedSample sample;
        for (std::size_t k = 0; k < scan.used; ++k)
            sample.counts[k] = static_cast<std::int32_t>(unpack(samples, scan.axes[k]));
        // The last sample of the buffer has just arrived; earlier ones arrived one step earlier each.
        sample.arrived_ns = now - std::llround(grid_.step_ns() * static_cast<double>(left));
        if (!scan.stamp) {
            place(sample);
            continue;
        }
        static_cast<void>(early_.push(sample.counts));  // a full ring: the sample counts as unheard
        sample.stamp_ns = unpack(samples, *scan.stamp);
        grid_.add(sample);
        while (const auto placed = grid_.next()) add(*placed);
    }
    clock_steps_ = grid_.clock_steps();
    bell_.ring();
}

/// Places a sample without stamp.
void IioAccelerometer::place(const TimedSample& sample) noexcept {
    const double passed_ns = static_cast<double>(sample.arrived_ns - last_arrived_ns_);
    const bool lost = std::exchange(broken_, false) && next_tick_ > 0;
    PlacedSample placed{sample, next_tick_, 0};
    if (lost) {
        placed.lost = std::max(0LL, std::llround(passed_ns / grid_.step_ns()) - 1);
        blocks_.begin_after_gap();  // samples that the host read late before the break may hide the loss
    }
    placed.tick += placed.lost;
    next_tick_ = placed.tick + 1;
    last_arrived_ns_ = sample.arrived_ns;
    add(placed);
}

void IioAccelerometer::add(const PlacedSample& placed) noexcept {
    const TimedSample& sample = placed.sample;
    const std::int64_t lag = sample.arrived_ns - sample.stamp_ns;
    const bool stamped = facts_.stamps == IioStamps::host && lag > -stamp_ahead_ns && lag < stamp_behind_ns;
    const std::int64_t at = stamped ? sample.stamp_ns : sample.arrived_ns;
    blocks_.add(placed.tick, placed.lost, sample.counts, host_time(at));
}

}  // namespace

std::unique_ptr<Accelerometer> open_iio_accelerometer(const IioSettings& settings,
                                                      std::vector<std::string>* notes) {
    auto opened = std::make_unique<IioAccelerometer>(settings);
    if (notes != nullptr)
        for (const std::string& note : opened->facts().notes)
            notes->push_back(opened->facts().name + ": " + note);
    return opened;
}

}  // namespace shaker::iio
