#include "daemon/commands/calibrate/led_attitudes.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <optional>
#include <span>
#include <vector>

#include "calibration/accelerometer/attitudes.hpp"
#include "calibration/accelerometer/sensor_file.hpp"
#include "daemon/bench/bench.hpp"
#include "daemon/commands/stop_signals.hpp"
#include "drivers/errors.hpp"
#include "drivers/time.hpp"

namespace shaker::commands {

namespace {

constexpr double hint_after_s = 20, patience_s = 300;
constexpr std::chrono::milliseconds longest_wait{200};

// The scales that the device reports, without the calibration that the rig file names.
calibration::Vector nominal_scales(const AccelerometerInfo& info) {
    if (info.calibration.empty()) return info.mps2_per_count;
    return calibration::parse_calibration(info.calibration, "calibration in force").nominal_mps2_per_count;
}

class Lead {
public:
    Lead(const LeadOptions& options, const std::function<void(const std::string&)>& show,
         const std::function<void(const std::string&)>& keep)
        : bench_{bench::open_bench(options.rig, options.scene, simulated::World::Pace::lockstep)},
          device_{*bench_.rig.accelerometer},
          info_{device_.info()},
          show_{show},
          keep_{keep},
          finder_{info_.rate_hz, options.hold_s, nominal_scales(info_), options.gravity} {
        if (bench_.world && bench_.scene.accelerometer.attitudes.empty())
            throw InputError{
                "--rig sim:: the scene holds the sensor in no attitudes; add `attitudes` to its "
                "[accelerometer]"};
        held_.sensor = info_.name;
        held_.nominal_mps2_per_count = nominal_scales(info_);
    }

    HeldRecords run() {
        keep_(held_header(held_));
        show_(fmt::format(
            "turn the sensor and hold it still in each attitude; the present one does not count. {} up\n",
            asked()));
        while (held_.attitudes.size() < standard_attitudes.size()) {
            StopSignals::rethrow();
            if (bench_.world) bench_.rig.dac->write(silence_, silence_);
            AccelBlock block;
            while (held_.attitudes.size() < standard_attitudes.size() &&
                   device_.read(block, bench_.world ? std::chrono::milliseconds{0} : longest_wait))
                take(block);
            if (device_.ended()) throw DeviceError{info_.name + ": delivers no more samples"};
        }
        return std::move(held_);
    }

private:
    [[nodiscard]] std::string asked() const {
        return std::string{
            standard_attitudes.at(std::min(held_.attitudes.size(), standard_attitudes.size() - 1))};
    }

    void take(const AccelBlock& block) {
        if (block.quality != Quality::good) finder_.begin_again();
        for (int i = 0; i < block.size; ++i) {
            if (auto attitude = finder_.add(block.counts[static_cast<std::size_t>(i)])) accept(*attitude);
            ++waited_;
        }
        const double waited_s = duration_s(waited_, info_.rate_hz);
        if (waited_s > patience_s)
            throw InputError{fmt::format("attitude {} up: not held within {:.0f} s ({})", asked(), patience_s,
                                         finder_.why_not())};
        if (waited_s < hint_after_s * (hints_ + 1)) return;
        ++hints_;
        show_(fmt::format("waiting for {} up: {}\n", asked(), finder_.why_not()));
    }

    void accept(calibration::Attitude& attitude) {
        attitude.name = asked();
        held_.attitudes.push_back(attitude);
        keep_(held_rows(attitude.name, finder_.record()));
        waited_ = hints_ = 0;
        const auto directions =
            calibration::nominal_directions(held_.attitudes, held_.nominal_mps2_per_count);
        const std::span<const std::string_view> missing =
            std::span{standard_attitudes}.subspan(held_.attitudes.size());
        const std::string_view reads = calibration::nearest_attitude(directions.back());
        show_(fmt::format("{}: held, {} of {}{}; condition number {:.3g}; missing: {}\n", attitude.name,
                          held_.attitudes.size(), standard_attitudes.size(),
                          reads == attitude.name ? "" : fmt::format(", reads as {} up", reads),
                          calibration::condition_of(directions),
                          missing.empty() ? "none" : fmt::format("{}", fmt::join(missing, " "))));
    }

    bench::Bench bench_;
    Accelerometer& device_;
    AccelerometerInfo info_;
    const std::function<void(const std::string&)>&show_, &keep_;
    calibration::HeldFinder finder_;
    HeldRecords held_{};
    std::vector<double> silence_ = std::vector<double>(bench_.rig.dac->info().block_frames);
    std::int64_t waited_ = 0;  // samples since the last attitude
    int hints_ = 0;
};

}  // namespace

HeldRecords lead(const LeadOptions& options, const std::function<void(const std::string&)>& show,
                 const std::function<void(const std::string&)>& keep) {
    const StopSignals signals;
    return Lead{options, show, keep}.run();
}

}  // namespace shaker::commands
