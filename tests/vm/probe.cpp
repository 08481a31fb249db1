// The drivers on a real kernel, one job after another (tests/vm/jobs). Each job prints a line that starts
// with "proved: ", or prints its error and ends with status 1.
#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <future>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>

#include "drivers/errors.hpp"
#include "drivers/hardware/alsa/alsa_dac.hpp"
#include "drivers/hardware/alsa/output_frames.hpp"
#include "drivers/hardware/alsa/pcm.hpp"
#include "drivers/hardware/alsa/settings.hpp"
#include "drivers/hardware/gpio/contact_input.hpp"
#include "drivers/hardware/iio/iio_accelerometer.hpp"
#include "drivers/hardware/iio/settings.hpp"
#include "drivers/hardware/video/video_camera.hpp"
#include "tests/support/devices/hard_stops.hpp"
#include "tests/vm/death.hpp"
#include "tests/vm/drive_device.hpp"
#include "tests/vm/heard_drive.hpp"
#include "tests/vm/pattern.hpp"
#include "tests/vm/switched_drive.hpp"

namespace {

using namespace shaker;
using Arguments = std::span<const std::string>;

struct NotProved : std::runtime_error {
    using std::runtime_error::runtime_error;
};

void require(bool holds, const std::string& otherwise) {
    if (!holds) throw NotProved{otherwise};
}

// Prints at once, because later steps may hang.
void proved(const std::string& what) {
    fmt::print("proved: {}\n", what);
    std::fflush(stdout);
}

// Settings of one device, in a separate file with the format of a rig file.
template <class Read>
auto settings(const std::string& file, Read read) {
    SettingsTable table = SettingsTable::from_file(file);
    auto result = read(table);
    table.finish();
    return result;
}

std::int64_t whole(const std::string& text) { return std::stoll(text); }

// play SETTINGS BITS FRAMES PPM TOLERANCE_PPM: all frames are played, and the clock has the expected error.
void play(Arguments a) {
    alsa::AlsaDac dac{settings(a[0], alsa::read_alsa_settings)};
    const int bits = std::stoi(a[1]);
    const Played played = play_pattern(dac, bits, whole(a[2]), [] {});
    require(played.fault.empty(), "the DAC failed: " + played.fault);
    const double expected = std::stod(a[3]), tolerance = std::stod(a[4]);
    const std::string clock =
        fmt::format("clock {:+.0f} ppm by its fit ({:+.0f} expected), stamps {:.2f} ms late on average",
                    played.ppm, expected, 1e3 * played.residual.count());
    require(std::abs(played.ppm - expected) <= tolerance, clock);
    proved(fmt::format("{} frames of {} bits played, {} underruns, {}", played.frames, bits,
                       played.counts.incidents, clock));
}

// find RECORDING BITS FRAMES SHARE: the recording has only played samples, to the bit, and at least this
// share.
void find(Arguments a) {
    const std::int64_t frames = whole(a[2]);
    const PatternFound found = find_pattern(a[0], std::stoi(a[1]), frames);
    const std::string what = fmt::format(
        "{} of {} frames bit-exact at the other end, in {} pieces (longest {}, {} skipped), {} foreign",
        found.exact, frames, found.pieces, found.longest, found.skipped, found.foreign);
    require(found.foreign == 0 &&
                static_cast<double>(found.exact) >= std::stod(a[3]) * static_cast<double>(frames),
            what);
    proved(what);
}

// death SETTINGS CAPTURE: one driving process is killed, another one stopped; the output then ends with a
// ramp.
void death(Arguments a) {
    const alsa::AlsaSettings dac = settings(a[0], alsa::read_alsa_settings);
    const double buffer_s = static_cast<double>(dac.buffer_frames) / dac.rate_hz;
    fmt::print("{}\n", alsa::AlsaPcm{dac}.granted().text());
    constexpr double ten_ms = 0.01, rounding = 1.001;
    for (const auto& [end, name] : {std::pair{End::stopped, "SIGSTOP"}, std::pair{End::killed, "SIGKILL"}}) {
        for (const double after_s : {0.4, 0.4037, 0.4071}) {  // at several phases of drive and block
            AfterDeath heard = hear_a_death(dac, a[1], Seconds{after_s}, end);
            int repeated = 0;  // a stall of the machine as long as the buffer invalidates the result
            while (heard.longest_pause.count() > buffer_s / 2 && ++repeated < 10)
                heard = hear_a_death(dac, a[1], Seconds{after_s}, end);
            const std::string what = fmt::format(
                "{} at level {:.2f}: silent after {:.1f} ms ({:.1f} ms of buffer), largest step {:.5f} of "
                "full scale, the drive's own is {:.5f}{}",
                name, heard.level, 1e3 * heard.sounds_on.count(), 1e3 * buffer_s, heard.largest_step,
                heard.drive_step, repeated == 0 ? "" : fmt::format(" ({} times repeated)", repeated));
            require(heard.level > 0.4 && heard.sounds_on.count() <= buffer_s + ten_ms &&
                        heard.largest_step <= rounding * heard.drive_step,
                    what);
            proved(what);
        }
    }
}

// stops SETTINGS COUNT DRIVE: hard stops at random phases; the codes of the recorded drive go to the file
// DRIVE, and to DRIVE.ramps the number of samples in ramps after underruns, which no recording has.
void stops(Arguments a) {
    const alsa::AlsaSettings s = settings(a[0], alsa::read_alsa_settings);
    alsa::AlsaDac dac{s};
    const alsa::AlsaGranted granted = dac.granted();
    fmt::print("{}\n", granted.text());
    const test::HardStops all = test::stop_hard(dac, static_cast<int>(whole(a[1])), 1);
    const alsa::PcmCodec codec{granted.format, granted.significant_bits, s.full_scale_V};
    const int container = s.format == alsa::SampleFormat::s16 ? 16 : 32;
    std::vector<std::int32_t> codes;
    for (const double volts : all.volts)
        codes.push_back(codec.code(volts) * (1 << (container - codec.bits())));
    write_codes(a[2], codes);
    constexpr std::int64_t doubtful = 64;  // samples around each
    std::ofstream{a[2] + ".ramps"} << static_cast<std::int64_t>(all.counts.incidents) *
                                          (s.ramp_frames() + doubtful);
    std::vector<double> silent_ms;
    double taken_ms = 0;
    for (const test::HardStop& stop : all.stops) {
        silent_ms.push_back(1e3 * stop.silent_s);
        taken_ms += 1e3 * static_cast<double>(stop.taken_back) / s.rate_hz;
        require(stop.taken_back > 0 || all.counts.incidents > 0, "a hard stop took nothing back");
    }
    require(!silent_ms.empty(), "every drive ended in an underrun");
    std::ranges::sort(silent_ms);
    const std::string what = fmt::format(
        "{} hard stops took {:.1f} of {:.1f} ms back on average; {:.1f} ms stay; silent after {:.1f} ms "
        "(median), {:.1f} ms (worst); largest step {:.5f} V, of drive and ramp together at most {:.5f} V; {} "
        "underruns",
        all.stops.size(), taken_ms / static_cast<double>(all.stops.size()),
        1e3 * granted.queue_frames / s.rate_hz, 1e3 * granted.kept_frames / s.rate_hz,
        silent_ms[silent_ms.size() / 2], silent_ms.back(), all.largest_step, all.own_step,
        all.counts.incidents);
    require(all.largest_step < all.own_step, what);
    proved(what);
}

// heard RECORDING BITS DRIVE SHARE: the recording has only samples of the drive, in order, and of ramps after
// underruns, and at least this share of the drive.
void heard(Arguments a) {
    const std::vector<std::int32_t> drive = read_codes(a[2]);
    const DriveFound found = find_drive(a[0], std::stoi(a[1]), drive);
    const std::string what = fmt::format(
        "{} samples of the drive bit-exact at the other end, in {} pieces, {} skipped, {} foreign",
        found.exact, found.pieces, found.skipped, found.foreign);
    const auto sounds = std::ranges::count_if(drive, [](std::int32_t code) { return code != 0; });
    std::int64_t ramps = 0;
    std::ifstream{a[2] + ".ramps"} >> ramps;
    require(found.foreign <= ramps &&
                static_cast<double>(found.exact) >= std::stod(a[3]) * static_cast<double>(sounds),
            what);
    proved(what);
}

// unplug SETTINGS MARKER: creates the file MARKER while it plays. The device is then unplugged, and the DAC
// must report that.
void unplug(Arguments a) {
    alsa::AlsaDac dac{settings(a[0], alsa::read_alsa_settings)};
    constexpr std::int64_t longer_than_any_patience = 2'880'000;  // a minute
    const Played played = play_pattern(dac, 16, longer_than_any_patience, [&] { std::ofstream{a[1]}; });
    const std::string what = fmt::format("unplugged after {} frames, within {:.0f} ms: \"{}\"", played.frames,
                                         1e3 * played.last_write_took.count(), played.fault);
    require(played.fault.find("No such device") != std::string::npos, what);
    proved(what);
}

// accelerometer SETTINGS SAMPLES: all samples are present and correct, and the driver reports no loss.
void accelerometer(Arguments a) {
    const auto device = iio::open_iio_accelerometer(settings(a[0], iio::read_iio_settings));
    const Heard heard = read_counted_samples(*device, whole(a[1]));
    const std::string what = fmt::format(
        "{} samples at {:.1f} Hz by their stamps: {} missing, {} lost by the driver's count, {} wrong, {} "
        "misplaced, "
        "{} incidents{}",
        heard.samples, heard.rate_hz, heard.missing, heard.counts.lost, heard.wrong, heard.misplaced,
        heard.counts.incidents, heard.fault.empty() ? "" : "; " + heard.fault);
    require(heard.samples >= whole(a[1]) && heard.missing == 0 && heard.counts.lost == 0 &&
                heard.wrong == 0 && heard.misplaced == 0 && heard.fault.empty(),
            what);
    proved(what);
}

// cameras SECONDS RATE_HZ SETTINGS...: all cameras together; each exposure is a frame or a counted loss.
void cameras(Arguments a) {
    const Seconds duration{std::stod(a[0])};
    const double rate_hz = std::stod(a[1]);
    // A picture late by half a period or more counts as a loss before it: emulated machines stamp late.
    constexpr double late_stamps = 0.03;
    std::vector<std::unique_ptr<Camera>> devices;
    for (const std::string& file : a.subspan(2)) {
        View view;
        view.camera = file;
        devices.push_back(video::open_video_camera(settings(file, video::read_video_settings), view));
    }
    std::vector<std::future<Watched>> watching;
    watching.reserve(devices.size());
    for (const auto& device : devices)
        watching.push_back(std::async(std::launch::async, [&] { return watch(*device, duration); }));
    for (std::size_t i = 0; i < watching.size(); ++i) {
        const Watched seen = watching[i].get();
        const auto counted = static_cast<std::int64_t>(seen.counts.lost);
        const std::string what = fmt::format(
            "camera {}: {} frames of {} exposures at {:.2f} Hz, {} lost by the driver's count, {} out of "
            "order, {} without a stamp{}",
            i, seen.frames, seen.span, seen.rate_hz, counted, seen.backwards, seen.unstamped,
            seen.fault.empty() ? "" : "; " + seen.fault);
        require(seen.fault.empty() && seen.backwards == 0 && seen.unstamped == 0 && seen.frames > 0 &&
                    seen.frames + counted >= seen.span && std::abs(seen.rate_hz / rate_hz - 1) < late_stamps,
                what);
        proved(what);
    }
}

// drive RIG SECONDS: drives on the [dac] and the [abort] of a file; after a trip it prints the trip and the
// time of its ramp, ns of CLOCK_MONOTONIC.
void drive(Arguments a) {
    SettingsTable root = SettingsTable::from_file(a[0]);
    SettingsTable dac = root.table("dac"), abort = root.table("abort");
    const gpio::AbortSettings contact = gpio::read_abort(abort);
    Rig rig;
    rig.dac = std::make_unique<alsa::AlsaDac>(alsa::read_alsa_settings(dac));
    rig.abort_input =
        std::make_unique<gpio::ContactInput>(gpio::open_input(contact.at, contact.pull), contact);
    const SwitchedDrive done = drive_switched(rig, std::stod(a[1]));
    require(done.trip.has_value(), "no trip");
    fmt::print("{}\nramp {}\n", text(*done.trip), done.ramp.time_since_epoch().count());
}

struct Job {
    std::string_view name;
    std::size_t arguments;  // at least
    void (*run)(Arguments);
};
constexpr Job jobs[] = {{"play", 5, play},
                        {"find", 4, find},
                        {"death", 2, death},
                        {"stops", 3, stops},
                        {"heard", 4, heard},
                        {"unplug", 2, unplug},
                        {"accelerometer", 2, accelerometer},
                        {"cameras", 3, cameras},
                        {"drive", 2, drive}};

}  // namespace

int main(int argc, char** argv) try {
    const std::vector<std::string> words(argv + 1, argv + argc);
    for (const Job& job : jobs)
        if (!words.empty() && words[0] == job.name && words.size() > job.arguments) {
            job.run(Arguments{words}.subspan(1));
            return 0;
        }
    fmt::print(stderr, "vm_probe is part of tests/vm/run; see tests/vm/jobs for its arguments\n");
    return 2;
} catch (const std::exception& error) {
    fmt::print("not proved: {}\n", error.what());
    return 1;
}
