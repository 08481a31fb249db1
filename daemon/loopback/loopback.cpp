#include "daemon/loopback/loopback.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "calibration/clocks/timebase.hpp"
#include "calibration/harmonics/harmonic_fit.hpp"
#include "drivers/drive.hpp"
#include "drivers/errors.hpp"
#include "drivers/hardware/hardware_rig.hpp"
#include "drivers/settings_table.hpp"
#include "drivers/time.hpp"
#include "drivers/with_error.hpp"

namespace shaker::loopback {

namespace {

using calibration::HarmonicFit;
constexpr double full_counts = 2147483648.0;
constexpr double tone_hz = 100, pulse_hz = 100, low_hz = 2;
constexpr std::array low_tones{1, 2, 4, 8, 16, 32, 64};  // times low_hz
constexpr int tone_harmonics = 5;
constexpr double quiet_s = 2, burst_s = 0.1, tone_s = 1, low_s = 6, low_settle_s = 2, edge_s = 0.02,
                 lead_s = 0.1, tail_s = 0.3, most_tail_s = 6;
constexpr double clear = 6;  // errors by which a burst is seen

struct Heard {
    std::vector<double> t_s, a;  // master time, m/s^2
    // With a slope: an input that is coupled by a capacitor settles slowly.
    [[nodiscard]] HarmonicFit fit(double frequency, int order) const {
        const calibration::HarmonicSamples samples{t_s, a, {}};
        return fit_harmonics({&samples, 1}, frequency, order, calibration::Slope::free);
    }
};

/// Plays through the output and collects what the input hears, both on master time.
class Cable {
public:
    Cable(Rig& rig, const Operator& person)
        : rig_{rig},
          person_{person},
          dac_{rig.dac->info()},
          sensor_{rig.accelerometer->info()},
          timebase_{{.dac_rate_hz = dac_.rate_hz,
                     .accelerometer_rate_hz = sensor_.rate_hz,
                     .first_sample_s = 0,
                     .dac_clock = sensor_.dac_clock,
                     .cameras = {}}} {}

    /// volts(t): of the drive, t: s since the start of the sound. The first and the last 20 ms rise and fall.
    /// Samples before settle_s do not count.
    template <class Volts>
    Heard play(double length_s, const Volts& volts, bool pulses = false, double settle_s = 2 * edge_s) {
        // The lead takes up what was lost while this program computed.
        write(
            lead_s, [](double) { return 0.0; }, false, true);
        const double from_s = played_s();
        samples_.clear();
        write(
            length_s, [&](double t) { return envelope(t, length_s) * volts(t); }, pulses);
        for (double s = 0; s < most_tail_s && !(heard_s() > from_s + length_s); s += tail_s)
            write(
                tail_s, [](double) { return 0.0; }, false);
        Heard heard;
        for (const auto& [tick, a] : samples_) {
            const double t_s = seconds(timebase_.at(tick));
            if (t_s < from_s + settle_s || t_s > from_s + length_s - edge_s) continue;
            heard.t_s.push_back(t_s - from_s);
            heard.a.push_back(a);
        }
        if (heard.t_s.size() < 10) throw DeviceError{sensor_.name + ": delivers no samples"};
        return heard;
    }
    [[nodiscard]] const DacInfo& dac() const noexcept { return dac_; }
    /// m/s^2 at the input's full scale.
    [[nodiscard]] double input_full() const noexcept { return sensor_.mps2_per_count[0] * full_counts; }

private:
    static double envelope(double t, double length_s) {
        const double edge = std::min({1.0, t / edge_s, (length_s - t) / edge_s});
        return 0.5 - 0.5 * std::cos(std::numbers::pi * std::max(0.0, edge));
    }
    // Time of the newest sample of the input; NaN: none.
    [[nodiscard]] double heard_s() const {
        return samples_.empty() ? NAN : seconds(timebase_.at(samples_.back().first));
    }
    [[nodiscard]] double played_s() const { return counted_s(DacTick{tick_}, dac_.rate_hz); }

    template <class Volts>
    void write(double length_s, const Volts& volts, bool pulses, bool may_lose = false) {
        const auto count = static_cast<std::int64_t>(length_s * dac_.rate_hz);
        const auto spacing = static_cast<std::int64_t>(dac_.rate_hz / pulse_hz);
        std::vector<double> drive(dac_.block_frames), trigger(dac_.block_frames);
        for (std::int64_t done = 0; done < count;) {
            person_.rethrow();
            for (std::size_t i = 0; i < drive.size(); ++i, ++done) {
                drive[i] = done < count ? volts(duration_s(done, dac_.rate_hz)) : 0;
                trigger[i] = pulses && done < count && done % spacing == 0 ? 1 : 0;
            }
            const PlayTime played = rig_.dac->write(drive, trigger);
            if (played.lost > 0 && !may_lose)
                throw DeviceError{dac_.name + ": ran empty while the cable was measured"};
            timebase_.add(played);
            tick_ += static_cast<std::int64_t>(drive.size()) + played.lost;
            for (AccelBlock block; rig_.accelerometer->read(block, std::chrono::milliseconds{0});) {
                timebase_.add(block);
                for (int i = 0; i < block.size; ++i)
                    samples_.emplace_back(AccelTick{block.first.n + i},
                                          sensor_.acceleration(block.counts[static_cast<std::size_t>(i)])[0]);
            }
        }
    }

    Rig& rig_;
    const Operator& person_;
    DacInfo dac_;
    AccelerometerInfo sensor_;
    calibration::Timebase timebase_;
    std::int64_t tick_ = 0;
    std::vector<std::pair<AccelTick, double>> samples_;
};

double tone(double volts, double t) { return volts * std::sin(2 * std::numbers::pi * tone_hz * t); }

double low_sound(double volts, double t) {
    double sum = 0;
    for (const int q : low_tones) sum += std::sin(2 * std::numbers::pi * low_hz * q * t);
    return volts * sum / static_cast<double>(low_tones.size());
}

// The input must show each level before the next one is played, as a cable does: in proportion, and low tones
// as loud as high ones. A shaker with a sensor does not.
void rise(Cable& cable, const Operator& person) {
    constexpr double same = 0.1, flat = 0.2;
    double before = NAN;
    for (const double level : {1e-3, 1e-2, 1e-1}) {
        const double volts = level * cable.dac().full_scale_V;
        const HarmonicFit fit = cable.play(burst_s, [&](double t) { return tone(volts, t); }).fit(tone_hz, 1);
        const double seen = std::abs(fit.at(1)), error = fit.amplitude_sd(1), gain = seen / volts;
        person.say(
            fmt::format("{:.0f} dB below full scale: the input shows {:.4g} +- {:.2g} of its full scale\n",
                        -20 * std::log10(level), seen / cable.input_full(), error / cable.input_full()));
        if (!(seen > clear * error))
            throw DeviceError{fmt::format(
                "the input does not show the output: {:.4g} V at {:.0f} Hz were played on the drive's "
                "channel, {:.2g} "
                "+- {:.2g} of full scale were heard; check the cable, drive_channel, channels and the mixer",
                volts, tone_hz, seen / cable.input_full(), error / cable.input_full())};
        if (std::abs(gain / before - 1) > same + 3 * error / seen)
            throw DeviceError{fmt::format(
                "this is no cable: the gain is {:.3g} and {:.3g} m/s^2 per V at two levels", before, gain)};
        before = gain;
        if (level != 1e-2) continue;
        constexpr double short_s = 1;
        const HarmonicFit low =
            cable.play(short_s, [&](double t) { return low_sound(volts, t); }).fit(low_hz, low_tones.back());
        constexpr int middle = 8;  // 16 Hz, above the corner of usual inputs
        const double ratio = std::abs(low.at(middle)) / std::abs(low.at(low_tones.back()));
        if (!(std::abs(ratio - 1) < flat))
            throw DeviceError{
                fmt::format("this is no cable: {:.0f} Hz is {:.3g} times as loud as {:.0f} Hz; is the "
                            "shaker connected? Switch the amplifier off",
                            middle * low_hz, ratio, low_tones.back() * low_hz)};
    }
}

// The corner of one pole: |r|^2 = f^2 / (f^2 + corner^2), relative to the highest tone; by the lowest tone.
calibration::Estimate corner_of(const HarmonicFit& low) {
    const int high = low_tones.back();
    const double ratio = std::abs(low.at(1)) / std::abs(low.at(high));
    const double error = ratio * std::hypot(low.amplitude_sd(1) / std::abs(low.at(1)),
                                            low.amplitude_sd(high) / std::abs(low.at(high)));
    const double square = 1 / (ratio * ratio) - 1, of_square = 2 * error / std::pow(ratio, 3);
    if (!(square > 2 * of_square)) return {0, low_hz * std::sqrt(std::max(0.0, square) + of_square)};
    return {low_hz * std::sqrt(square), low_hz * of_square / (2 * std::sqrt(square))};
}

// By the phases of the tones, each with the lead of the corner taken off. A higher tone counts its turns by
// the lower ones.
calibration::Estimate delay_of(const HarmonicFit& low, double corner_hz) {
    double weight = 0, sum = 0;
    for (const int q : low_tones) {
        const double f = q * low_hz, w = 2 * std::numbers::pi * f, so_far = weight > 0 ? sum / weight : 0;
        // The fit's phases are at its origin, the tones' at 0.
        const double lag = w * low.origin_s - std::arg(low.at(q)) + std::atan2(corner_hz, f);
        const double delay = so_far + std::remainder(lag - w * so_far, 2 * std::numbers::pi) / w;
        const double u = std::pow(w / low.phase_sd(q), 2);
        sum += u * delay;
        weight += u;
    }
    return {sum / weight, 1 / std::sqrt(weight)};
}

}  // namespace

Rig open_sound(const std::string& rig_file, std::vector<std::string>& granted) {
    SettingsTable root = SettingsTable::from_file(rig_file), sensor = root.table("accelerometer"),
                  output = root.table("dac");
    if (const std::string driver =
            sensor.text("driver", std::string{hardware::accelerometer_kinds.front().name});
        driver != "alsa")
        sensor.fail("driver", "\"" + driver + "\" has no input for a cable: expected \"alsa\"");
    Rig rig;
    rig.name = rig_file;
    rig.accelerometer = alsa_input::read_kind(sensor)(granted);
    rig.dac = alsa::read_kind(output)(granted);
    return rig;
}

Measured measure(Rig& rig, const Operator& person) {
    Cable cable{rig, person};
    rig.dac->enable(false);
    Measured m;
    const double full_V = cable.dac().full_scale_V, full = cable.input_full();
    const Heard quiet = cable.play(quiet_s, [](double) { return 0.0; });
    double mean = 0, square = 0;
    for (const double a : quiet.a) mean += a / static_cast<double>(quiet.a.size());
    for (const double a : quiet.a) square += std::pow(a - mean, 2) / static_cast<double>(quiet.a.size());
    m.noise = std::sqrt(square) / full;
    rise(cable, person);
    const double volts = 0.1 * full_V;
    // All is played before the long fits: the output must not run empty.
    const Heard loud = cable.play(tone_s, [&](double t) { return tone(volts, t); });
    const Heard deep = cable.play(
        low_s, [&](double t) { return low_sound(volts, t); }, false, low_settle_s);
    const Heard silent = cable.play(
        tone_s, [](double) { return 0.0; }, true);
    const HarmonicFit sound = loud.fit(tone_hz, tone_harmonics), low = deep.fit(low_hz, low_tones.back()),
                      pulses = silent.fit(pulse_hz, tone_harmonics);
    m.gain = {std::abs(sound.at(1)) / volts, sound.amplitude_sd(1) / volts};
    m.share = {m.gain.value * full_V / full, m.gain.sigma * full_V / full};
    double others = 0;
    for (int q = 2; q <= tone_harmonics; ++q) others += std::norm(sound.at(q));
    m.distortion = std::sqrt(others) / std::abs(sound.at(1));
    m.corner_hz = corner_of(low);
    m.delay_s = delay_of(low, m.corner_hz.value);
    for (int q = 1; q <= tone_harmonics; ++q)
        m.pulses = std::max(m.pulses, std::abs(pulses.at(q)) / (m.gain.value * full_V));
    return m;
}

std::string text(const Measured& m, double dac_full_scale_V) {
    const auto decibel = [](double share) {
        return share > 0 ? fmt::format("{:.1f} dB", 20 * std::log10(share)) : "none";
    };
    std::string s;
    const auto line = [&](const char* what, const std::string& value) {
        s += fmt::format("  {:<40}{}\n", what, value);
    };
    line("gain at 100 Hz", with_error(m.share.value, m.share.sigma) + " of full scale per full scale");
    line("delay by the stamps", with_error(1e3 * m.delay_s.value, 1e3 * m.delay_s.sigma) + " ms");
    line("lower corner of output and input", m.corner_hz.value > 0
                                                 ? with_error(m.corner_hz.value, m.corner_hz.sigma) + " Hz"
                                                 : fmt::format("below {:.2g} Hz", 2 * m.corner_hz.sigma));
    line("noise of the input at rest", decibel(m.noise) + " of its full scale");
    line("distortion at 20 dB below full scale", decibel(m.distortion));
    line("pulses of the trigger in the drive", decibel(m.pulses) + " of a full drive");
    s += fmt::format(
        "with [dac] full_scale_V = {:.6g}, the input has\n[accelerometer] full_scale_V = {:.5g}\n",
        dac_full_scale_V, dac_full_scale_V / m.share.value);
    return s;
}

std::string json(const Measured& m, double dac_full_scale_V) {
    nlohmann::ordered_json j;
    const auto add = [&](const char* name, const calibration::Estimate& e) {
        j[name] = e.value;
        j[std::string{name} + "_se"] = e.sigma;
    };
    add("gain_mps2_per_V", m.gain);
    add("share", m.share);
    add("delay_s", m.delay_s);
    add("corner_hz", m.corner_hz);
    j["noise"] = m.noise;
    j["distortion"] = m.distortion;
    j["pulses"] = m.pulses;
    j["full_scale_V"] = dac_full_scale_V / m.share.value;
    return j.dump(2) + "\n";
}

}  // namespace shaker::loopback
