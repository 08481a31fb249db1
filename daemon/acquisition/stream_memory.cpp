#include "daemon/acquisition/stream_memory.hpp"

#include <spdlog/fmt/fmt.h>

#include <fstream>
#include <limits>
#include <string>

#include "daemon/acquisition/streams.hpp"
#include "drivers/errors.hpp"

namespace shaker::acquisition {

namespace {

constexpr double copies = 3;             // growing lists, and the input of the reduction
constexpr double samples_of_block = 16;  // at least, so that this is an upper bound for usual sensors

double available_bytes() {
    std::ifstream in{"/proc/meminfo"};
    for (std::string key, unit; in >> key;) {
        double kib = 0;
        if (!(in >> kib)) break;
        if (key == "MemAvailable:") return 1024 * kib;
        std::getline(in, unit);
    }
    return std::numeric_limits<double>::infinity();
}

}  // namespace

double memory_of(const Rig& rig, double measured_s) {
    double per_s = 0;
    for (const auto& camera : rig.cameras) {
        const View& view = camera->view();
        per_s += view.frame_rate_hz * (static_cast<double>(view.targets.size() * sizeof(tracking::Track)) +
                                       sizeof(calibration::FrameStamp));
    }
    if (rig.accelerometer) per_s += rig.accelerometer->info().rate_hz / samples_of_block * sizeof(AccelBlock);
    if (rig.dac) {
        const DacInfo dac = rig.dac->info();
        per_s += dac.rate_hz / static_cast<double>(dac.block_frames) * sizeof(PlayTime);
    }
    return copies * per_s * measured_s;
}

void require_memory(const Rig& rig, double measured_s) {
    const double needed = memory_of(rig, measured_s), available = available_bytes();
    if (needed <= available) return;
    throw InputError{
        fmt::format("a measurement of {:.0f} s needs {:.1f} GB of memory, {:.1f} GB are available: at most "
                    "{:.0f} s fit; measure fewer periods, or many times by \"shakerd serve\"",
                    measured_s, 1e-9 * needed, 1e-9 * available, measured_s * available / needed)};
}

}  // namespace shaker::acquisition
