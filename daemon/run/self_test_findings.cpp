#include <spdlog/fmt/fmt.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <list>
#include <numbers>
#include <optional>

#include "calibration/clocks/timebase.hpp"
#include "calibration/harmonics/harmonic_fit.hpp"
#include "daemon/reduction/check/bench_check.hpp"
#include "daemon/reduction/selection.hpp"
#include "daemon/run/self_test.hpp"
#include "daemon/safety/limits.hpp"
#include "drivers/with_error.hpp"

namespace shaker::run {

namespace {

using Complex = std::complex<double>;
constexpr double most_ppm = 200;                           // largest rate error of a crystal
constexpr double few_pictures = 0.02, most_missing = 0.2;  // share of the pictures that are missing
constexpr double on_the_way_s = 0.2;                       // the newest pictures may come later
constexpr double most_gravity = 0.05;    // largest relative error of gravity at rest without a warning
constexpr double most_noise = 0.1;       // m/s^2 rms at rest without a warning
constexpr double most_core_share = 0.6;  // of a camera's tracking; acquisition bounds it to this
constexpr double deg = 180 / std::numbers::pi;

// Harmonics 1 and 2 of the base's acceleration along an axis, measured by one instrument. m/s^2; phases
// relative to the drive.
struct Motion {
    std::array<Complex, 2> a{};
    std::array<double, 2> sd{};
    [[nodiscard]] bool seen() const { return std::abs(a[0]) > 5 * sd[0] && std::abs(a[1]) > 5 * sd[1]; }
    // alpha2 - 2 alpha1, rad: independent of a delay; a change of sign adds pi.
    [[nodiscard]] double shape() const { return std::arg(a[1]) - 2 * std::arg(a[0]); }
};

class Judge {
public:
    Judge(const SelfTest& test, const Rig& rig, acquisition::Streams& streams,
          const std::list<acquisition::TimeHistogram>& tracking)
        : test_{test}, rig_{rig}, streams_{streams}, tracking_{tracking}, measured_{measurement(streams)} {}
    std::vector<Finding> findings() {
        dac();
        if (rig_.accelerometer) accelerometer();
        for (std::size_t i = 0; i < rig_.cameras.size(); ++i) camera(i);
        motion();
        return std::move(findings_);
    }

private:
    [[nodiscard]] reduction::Measurement measurement(acquisition::Streams& streams) const {
        std::vector<std::string> notes;
        settle_times(streams, notes);
        return measurement_of(streams, test_.plan().frequency, test_.quiet().from_s, test_.held().to_s);
    }
    void add(Verdict verdict, const std::string& device, std::string text) {
        findings_.push_back({verdict, device, std::move(text)});
    }
    void clock(const std::string& device, const DeviceAdvice& advice, double nominal_hz,
               const calibration::ClockFit& c) {
        const bool crystal = std::abs(c.ppm) < most_ppm + 4 * c.ppm_sigma;
        add(crystal ? Verdict::good : Verdict::warning, device,
            fmt::format(
                "{:.6g} Hz, {} ppm fast relative to the host's clock; time stamps arrive {:.3g} us later "
                "than the earliest, on average{}",
                nominal_hz, with_error(c.ppm, c.ppm_sigma), 1e6 * c.delay.count(),
                crystal ? "" : fmt::format("; too far off for a crystal: {}", advice.rate_off)));
    }
    void losses(const std::string& device, const char* what, const DeviceCounts& c) {
        const bool clean = c.lost == 0 && c.incidents == 0 && c.reopened == 0;
        add(clean ? Verdict::good : Verdict::warning, device,
            fmt::format("{} {}, {} lost, {} incidents, reopened {} times", c.taken, what, c.lost, c.incidents,
                        c.reopened));
    }
    void dac();
    void accelerometer();
    void noise(const std::string& name, const std::array<std::vector<double>, 3>& quiet);
    void camera(std::size_t index);
    void missing_pictures(const std::string& name, std::size_t index);
    void pace(const std::string& name, std::size_t index, double rate_hz);
    void motion();
    [[nodiscard]] std::optional<Motion> by_accelerometer();
    [[nodiscard]] std::optional<Motion> by_cameras() const;
    void response(const Motion& m);
    /// Phase of the motion's shape off that of the data sheet, rad, -pi to pi; near +-pi: inverted.
    [[nodiscard]] double shape_off(const Motion& m) const {
        const double sheet = std::arg(test_.plan().response[1]) - 2 * std::arg(test_.plan().response[0]);
        return std::remainder(m.shape() - sheet, two_pi);
    }
    [[nodiscard]] bool inverted(const Motion& m) const {
        return std::abs(shape_off(m)) > 2 * std::numbers::pi / 3;
    }
    void polarity(const std::string& device, const Motion& m, const char* cure);

    const SelfTest& test_;
    const Rig& rig_;
    acquisition::Streams& streams_;
    const std::list<acquisition::TimeHistogram>& tracking_;
    reduction::Measurement measured_;
    std::vector<Finding> findings_;
};

void Judge::dac() {
    const std::string name = rig_.dac->info().name;
    clock(name, rig_.advice.dac, streams_.dac_rate_hz, streams_.timebase.dac());
    losses(name, "samples played", rig_.dac->counts());
}

void Judge::accelerometer() {
    const AccelerometerInfo info = rig_.accelerometer->info();
    if (streams_.blocks.empty()) {
        add(Verdict::bad, info.name, fmt::format("no samples arrived: {}", rig_.advice.accelerometer.silent));
        return;
    }
    clock(info.name, rig_.advice.accelerometer, info.rate_hz, streams_.timebase.accelerometer());
    losses(info.name, "samples", rig_.accelerometer->counts());
    if (info.dac_clock) {
        const calibration::ClockFit dac = streams_.timebase.dac(), own = streams_.timebase.accelerometer();
        const double apart = own.ppm - dac.ppm, sd = std::hypot(own.ppm_sigma, dac.ppm_sigma);
        constexpr double errors = 5, small_ppm = 20;
        const bool two = std::abs(apart) > errors * sd, known = errors * sd < small_ppm;
        add(two ? Verdict::bad : Verdict::good, info.name,
            fmt::format("its clock is {} ppm off that of the DAC: {}", with_error(apart, sd),
                        two     ? "it is another card: set clock = \"own\" in [accelerometer]"
                        : known ? "one clock"
                                : "no contradiction to one clock, in this short test"));
    }
    std::array<std::vector<double>, 3> quiet;
    const reduction::AccelSeries& s = measured_.accelerometer;
    for (std::size_t i = 0; i < s.t_s.size(); ++i)
        if (s.t_s[i] >= test_.quiet().from_s && s.t_s[i] <= test_.quiet().to_s)
            for (std::size_t k = 0; k < 3; ++k) quiet[k].push_back(s.a_mps2[i][k]);
    if (quiet[0].size() > 10) noise(info.name, quiet);
    const auto clipped = std::ranges::count_if(
        streams_.blocks, [](const AccelBlock& b) { return has(b.quality, Quality::clipped); });
    if (clipped > 0)
        add(Verdict::warning, info.name,
            fmt::format("{} blocks reach the end of its range: select a larger range, check the mounting",
                        clipped));
}

void Judge::noise(const std::string& name, const std::array<std::vector<double>, 3>& quiet) {
    const AccelerometerInfo info = rig_.accelerometer->info();
    const auto axes = static_cast<std::size_t>(info.axes);
    Eigen::Vector3d mean, sd;
    for (int k = 0; k < 3; ++k) {
        const std::vector<double>& q = quiet[static_cast<std::size_t>(k)];
        const Eigen::Map<const Eigen::VectorXd> v(q.data(), static_cast<Eigen::Index>(q.size()));
        mean(k) = v.mean();
        sd(k) = std::sqrt((v.array() - mean(k)).square().mean());
    }
    const std::span<const double> noise{sd.data(), axes};
    if (std::ranges::min(noise) == 0) {
        add(Verdict::bad, name, "an axis is constant, even without noise: frozen or not connected");
        return;
    }
    const std::array<double, 3> density = [&] {
        const double per = 1e6 / paper_g / std::sqrt(info.rate_hz / 2);
        return std::array{per * sd(0), per * sd(1), per * sd(2)};
    }();
    constexpr std::array<std::string_view, 3> names{"x", "y", "z"};
    const bool quiet_enough = std::ranges::max(noise) < most_noise;
    add(quiet_enough ? Verdict::good : Verdict::warning, name,
        fmt::format(
            "noise at rest {:.3g} m/s^2 rms on {} ({:.3g} ug/rtHz if white){}", fmt::join(noise, ", "),
            fmt::join(std::span{names}.first(axes), ", "), fmt::join(std::span{density}.first(axes), ", "),
            quiet_enough ? "" : ": large: check for hum (one ground only), a moving table and a loose lead"));
    if (!info.gravity) {
        add(Verdict::good, name,
            fmt::format("its reading has no gravity, which would show the gain; constant part {:.3g} m/s^2",
                        mean.norm()));
        return;
    }
    const double off = mean.norm() / test_.plan().gravity - 1;
    const bool fits = std::abs(off) < most_gravity;
    const bool wrong = safety::gravity_wrong(mean.norm(), test_.plan().gravity,
                                             safety::most_gravity_off(!info.calibration.empty()));
    add(fits    ? Verdict::good
        : wrong ? Verdict::bad
                : Verdict::warning,
        name,
        fmt::format(
            "measures {:.4f} m/s^2 along ({:+.3f}, {:+.3f}, {:+.3f}) at rest: gravity {}", mean.norm(),
            mean(0) / mean.norm(), mean(1) / mean.norm(), mean(2) / mean.norm(),
            fits ? "is correct" : fmt::format("is {:+.1f} % off: check scale, range and offset", 100 * off)));
}

void Judge::camera(std::size_t index) {
    const Camera& device = *rig_.cameras[index];
    const View& view = device.view();
    const std::string name = "camera \"" + view.camera + "\"";
    const acquisition::CameraStream& taken = streams_.cameras[index];
    const DeviceAdvice advice =
        index < rig_.advice.cameras.size() ? rig_.advice.cameras[index] : DeviceAdvice{};
    losses(name, "frames", device.counts());
    missing_pictures(name, index);
    for (std::size_t i = 0; i < view.targets.size(); ++i) {
        const std::vector<tracking::Track>& tracks = streams_.tracks[taken.first_track + i].tracks;
        if (tracks.empty()) {
            add(Verdict::bad, name, fmt::format("no frames arrived: {}", advice.silent));
            return;
        }
        const auto good = std::ranges::count_if(
            tracks, [](const tracking::Track& t) { return t.fix.state == tracking::TrackState::ok; });
        const bool fine = 100 * good >= 99 * static_cast<std::ptrdiff_t>(tracks.size());
        add(fine ? Verdict::good : Verdict::warning, name,
            fmt::format("\"{}\" found in {} of {} frames{}", view.targets[i].name, good, tracks.size(),
                        fine ? "" : ": check light, focus, roi_px and kind of the target"));
    }
    pace(name, index, view.frame_rate_hz);
    if (const auto own = streams_.timebase.camera_stamps(index))
        clock(name, advice, view.frame_rate_hz, *own);
}

// By their numbers, and by the time from the first to the end: a camera that misses triggers counts nothing.
void Judge::missing_pictures(const std::string& name, std::size_t index) {
    const acquisition::CameraStream& stream = streams_.cameras[index];
    std::vector<double> t;
    for (const tracking::Track& track : streams_.tracks.at(stream.first_track).tracks)
        if (std::isfinite(seconds(track.time))) t.push_back(seconds(track.time));
    const DeviceCounts counts = rig_.cameras[index]->counts();
    const auto taken = static_cast<double>(counts.taken), lost = static_cast<double>(counts.lost);
    double share = taken > 0 ? lost / (taken + lost) : 0;
    if (t.size() > 1 && !streams_.played.empty()) {
        const double played_s = seconds(streams_.timebase.at(streams_.played.back().tick));
        const double to_s = std::max(t.back(), played_s - on_the_way_s);
        const double due = stream.view.frame_rate_hz * (to_s - t.front());
        share = std::max(share, 1 - static_cast<double>(t.size() - 1) / due);
    }
    if (share > few_pictures)
        add(share > most_missing ? Verdict::bad : Verdict::warning, name,
            fmt::format("{:.1f} % of the pictures are missing (a warning above {:.0f} %, not fit above "
                        "{:.0f} %): check "
                        "cable, bandwidth, exposure_s and the rate that the camera reaches when triggered",
                        100 * share, 100 * few_pictures, 100 * most_missing));
}

// Whether this computer tracks pictures as fast as they come.
void Judge::pace(const std::string& name, std::size_t index, double rate_hz) {
    const acquisition::TimeHistogram::Seen seen =
        std::next(tracking_.begin(), static_cast<std::ptrdiff_t>(index))->seen();
    if (seen.total() == 0) return;
    const double share = rate_hz * seen.mean_s();
    add(share < most_core_share ? Verdict::good : Verdict::warning, name,
        fmt::format("a picture is tracked in {:.0f} us on average, 99.9 % of them in less than {:.0f} us: "
                    "{:.1f} % of a "
                    "processor at {:.4g} pictures/s{}",
                    1e6 * seen.mean_s(), 1e6 * acquisition::TimeHistogram::quantile(seen, 0.999), 100 * share,
                    rate_hz,
                    share < most_core_share ? ""
                                            : "; this computer cannot keep up: lower the frame rate, or draw "
                                              "smaller regions"));
}

std::optional<Motion> Judge::by_accelerometer() {
    const reduction::AccelSeries& s = measured_.accelerometer;
    std::vector<double> t;
    std::array<std::vector<double>, 3> a;
    for (std::size_t i = 0; i < s.t_s.size(); ++i) {
        if (s.t_s[i] < test_.held().from_s || s.t_s[i] > test_.held().to_s) continue;
        t.push_back(s.t_s[i]);
        for (std::size_t k = 0; k < 3; ++k) a[k].push_back(s.a_mps2[i][k]);
    }
    if (t.size() < 100) return {};
    Eigen::Matrix<double, 3, 4> parts;
    std::array<double, 2> sd{};
    Complex turn1, turn2;
    for (int k = 0; k < 3; ++k) {
        const calibration::HarmonicSamples samples{t, a[static_cast<std::size_t>(k)], {}};
        const calibration::HarmonicFit fit =
            fit_harmonics({&samples, 1}, test_.plan().frequency, 4, calibration::Slope::none);
        turn1 = std::polar(1.0, -two_pi * fit.frequency_hz * fit.origin_s);  // phases from master time 0
        turn2 = turn1 * turn1;
        const Complex a1 = fit.at(1) * turn1, a2 = fit.at(2) * turn2;
        parts.row(k) << a1.real(), a1.imag(), a2.real(), a2.imag();
        sd = {std::max(sd[0], fit.amplitude_sd(1)), std::max(sd[1], fit.amplitude_sd(2))};
    }
    Eigen::Vector3d axis(s.shaker_axis[0], s.shaker_axis[1], s.shaker_axis[2]);
    if (axis.norm() == 0) {
        const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(parts * parts.transpose());
        axis = eigen.eigenvectors().col(2);
        Eigen::Index largest = 0;
        axis.cwiseAbs().maxCoeff(&largest);
        if (axis(largest) < 0) axis = -axis;
    }
    const Eigen::RowVector4d along = axis.transpose() * parts;
    const double across = (parts - axis * along).norm() / along.norm();
    Motion m{{Complex{along(0), along(1)}, Complex{along(2), along(3)}}, sd};
    if (m.seen() && rig_.accelerometer->info().axes == 3)
        add(across > 0.1 ? Verdict::warning : Verdict::good, rig_.accelerometer->info().name,
            fmt::format(
                "base moves along ({:+.3f}, {:+.3f}, {:+.3f}) in the sensor's axes, {:.1f} % across{}",
                axis(0), axis(1), axis(2), 100 * across,
                across > 0.1 ? ": check that the sensor is mounted as shaker_axis says" : ""));
    return m;
}

std::optional<Motion> Judge::by_cameras() const {
    if (measured_.bases.empty()) return {};
    std::vector<reduction::MotionSeries> held;
    for (reduction::MotionSeries s : measured_.bases) {
        reduction::MotionSeries cut;
        for (std::size_t i = 0; i < s.t_s.size(); ++i)
            if (s.t_s[i] >= test_.held().from_s && s.t_s[i] <= test_.held().to_s) {
                cut.t_s.push_back(s.t_s[i]);
                cut.x_m.push_back(s.x_m[i]);
                cut.sd_m.push_back(s.sd_m[i]);
            }
        if (cut.t_s.size() > 50) held.push_back(std::move(cut));
    }
    if (held.empty()) return {};
    const calibration::HarmonicFit fit =
        reduction::fit_views(sums_of(held, test_.plan().frequency, 2, calibration::Slope::free), 2).fit;
    const Complex turn = std::polar(1.0, -two_pi * fit.frequency_hz * fit.origin_s);
    const double w2 = std::pow(two_pi * fit.frequency_hz, 2);
    return Motion{{-w2 * fit.at(1) * turn, -4 * w2 * fit.at(2) * turn * turn},
                  {w2 * fit.amplitude_sd(1), 4 * w2 * fit.amplitude_sd(2)}};
}

void Judge::response(const Motion& m) {
    const double volts = test_.plan().volts;
    for (std::size_t k = 0; k < 2; ++k) {
        const double got = std::abs(m.a[k]) / volts, sheet = std::abs(test_.plan().response[k]);
        const bool fits = got > 0.5 * sheet && got < 2 * sheet;
        add(fits ? Verdict::good : Verdict::warning, "shaker",
            fmt::format("{} m/s^2 per volt at {:.4g} Hz; data sheet {:.4g}{}",
                        with_error(got, m.sd[k] / volts), static_cast<double>(k + 1) * test_.plan().frequency,
                        sheet,
                        fits ? ""
                             : ": check the amplifier's gain, any volume knob, full_scale_V, the masses in "
                               "[shaker] and the sensor's scale"));
    }
}

void Judge::polarity(const std::string& device, const Motion& m, const char* cure) {
    const double off = shape_off(m);
    if (std::abs(off) < std::numbers::pi / 3)
        add(Verdict::good, device,
            fmt::format("polarity is right: positive volts move the base towards +x (shape {:+.1f} deg off)",
                        deg * off));
    else if (inverted(m))
        add(Verdict::bad, device, fmt::format("polarity is inverted: {}", cure));
    else
        add(Verdict::warning, device,
            fmt::format("polarity is undetermined: the second harmonic is {:+.0f} deg off the data sheet; "
                        "check for a distorted drive and for other devices in the signal path",
                        deg * off));
}

void Judge::motion() {
    const auto a = by_accelerometer(), c = by_cameras();
    constexpr const char* wires = "swap the wires of the shaker";
    if (a && a->seen()) {
        response(*a);
        const bool alone = c && c->seen() && !inverted(*c);
        polarity(rig_.accelerometer->info().name, *a,
                 alone ? "the cameras disagree: correct the sign of the sensor's shaker_axis" : wires);
    } else if (a && c && c->seen()) {
        add(Verdict::bad, rig_.accelerometer->info().name,
            fmt::format("does not show the motion that the cameras see: {:.2g} +- {:.1g} m/s^2 instead of "
                        "{:.2g}; check "
                        "its lead, its supply or conditioner, and its channel",
                        std::abs(a->a[0]), a->sd[0], std::abs(c->a[0])));
    } else if (a) {
        add(Verdict::bad, "shaker",
            fmt::format("base does not move: {:.2g} +- {:.1g} m/s^2 at {:.4g} V; check amplifier and cables; "
                        "without pictures, check whether drive_channel and trigger_channel are swapped",
                        std::abs(a->a[0]), a->sd[0], test_.plan().volts));
    }
    if (c && c->seen()) {
        const bool alone = a && a->seen() && !inverted(*a);
        polarity("cameras", *c,
                 alone ? "the accelerometer disagrees: reverse `along` of the cameras" : wires);
        if (a && a->seen()) {
            const double ratio = std::abs(c->a[0]) / std::abs(a->a[0]);
            const double sd = ratio * std::hypot(c->sd[0] / std::abs(c->a[0]), a->sd[0] / std::abs(a->a[0]));
            const bool fits = std::abs(ratio - 1) < std::max(0.02, 4 * sd);
            add(fits ? Verdict::good : Verdict::warning, "cameras",
                fmt::format("ratio of the base's acceleration, cameras to accelerometer: {}{}",
                            with_error(ratio, sd),
                            fits ? ""
                                 : ": check mm_per_px, offset_mm and the sensor's scale" +
                                       reduction::scale_cause(ratio)));
        }
    } else if (c) {
        add(Verdict::good, "cameras", "base motion is too small for the cameras at this level");
    }
}

}  // namespace

std::vector<Finding> judge(const SelfTest& test, const Rig& rig, acquisition::Collector& collector) {
    return Judge{test, rig, collector.streams(), collector.channels().tracking}.findings();
}

}  // namespace shaker::run
