#include "daemon/commissioning/commission.hpp"

#include <spdlog/fmt/fmt.h>
#include <stdlib.h>

#include <array>
#include <cmath>
#include <numbers>

#include "daemon/commissioning/doors.hpp"
#include "daemon/commissioning/results.hpp"
#include "daemon/commissioning/session.hpp"
#include "daemon/commissioning/switches.hpp"
#include "daemon/recording/time_text.hpp"
#include "drivers/commissioned/record.hpp"
#include "drivers/errors.hpp"

namespace shaker::commissioning {

namespace {

using commissioned::Item;
using safety::Cause;

// The friction of the walker changes the load and adds harmonics to the peak of the drive.
constexpr double step_tolerance = 0.2;
constexpr double sheet_factor = 1.5;

// A folder for the socket and the files of stopped runs, removed at the end.
class Folder {
public:
    Folder() {
        std::string name = (std::filesystem::temp_directory_path() / "commissioning-XXXXXX").string();
        if (::mkdtemp(name.data()) == nullptr) throw DeviceError{name + ": cannot be made"};
        path = name;
    }
    ~Folder() {
        std::error_code ignored;
        std::filesystem::remove_all(path, ignored);
    }
    Folder(const Folder&) = delete;
    Folder& operator=(const Folder&) = delete;
    std::filesystem::path path;
};

class Day {
public:
    Day(const Settings& settings, const Operator& person)
        : session_{settings.rig,
                   {.frequency = settings.frequency_hz},
                   folder_.path,
                   person.rethrow,
                   settings.fit},
          results_{person, {{"self-test", settings.self_test}}} {
        DacInfo dac = session_.bench().rig.dac->info();
        sheet_ = std::abs(session_.bench().response(settings.frequency_hz));
        full_ = {.frequency = settings.frequency_hz,
                 .gamma = settings.level * dac.full_scale_V * sheet_,
                 .rho = 1};
    }

    bool lead() {
        if (!polarity() || !enable_output(session_, full_, results_)) return false;
        abort_input(session_, full_, results_);
        return gain() && limits() && aborts() && emergency_stop();
    }
    [[nodiscard]] const std::vector<Item>& items() const { return results_.items(); }
    /// The rig file as it was opened.
    [[nodiscard]] const std::string& rig_text() { return session_.bench().rig_text; }

private:
    bool polarity() {
        return results_.agreed(
            "polarity by hand",
            "Push the base by hand towards +x of the rig file. Does it move along the key `along` in every "
            "picture, and along `shaker_axis` of the accelerometer?");
    }

    // A step of the drive to twice its level.
    bool gain() {
        Drive half = full_;
        half.gamma /= 2;
        const service::BaseState low = *session_.drive(half)->base;
        const service::BaseState high = *session_.drive(full_)->base;
        const double step = high.volts_peak / low.volts_peak, gain = high.got.gamma / high.volts_peak;
        const std::string seen = fmt::format(
            "{:.4g} m/s^2 per V, by the data sheet {:.4g}; for twice the motion {:.3f} times the drive", gain,
            sheet_, step);
        if (std::abs(step / 2 - 1) > step_tolerance || gain > sheet_factor * sheet_ ||
            gain * sheet_factor < sheet_)
            throw DeviceError{"gain by a known step: " + seen +
                              "; check full_scale_V, the gain of the amplifier and the masses"};
        results_.add("gain by a known step", seen);
        return results_.agreed(
            "voltage at the output",
            fmt::format("The drive is on. A true-RMS meter at output 1 must show {:.4g} V, within 5 %. "
                        "Does it?",
                        high.volts_peak / std::numbers::sqrt2));
    }

    // Each limit is lowered to half of what the base does.
    bool limits() {
        const double omega = 2 * std::numbers::pi * full_.frequency;
        struct Crossed {
            Cause cause;
            safety::Level safety::Limits::*level;
            double present;
        };
        for (const Crossed& c :
             {Crossed{Cause::acceleration, &safety::Limits::acceleration, full_.gamma},
              Crossed{Cause::velocity, &safety::Limits::velocity, full_.gamma / omega},
              Crossed{Cause::displacement, &safety::Limits::displacement, full_.gamma / omega / omega},
              Crossed{Cause::drive, &safety::Limits::drive, full_.gamma / sheet_}}) {
            session_.drive(full_);
            const service::LowerLimit lowered{{c.level}, c.present / 2};
            const SeenStop stop = session_.stopped_by([&] { session_.order(lowered); });
            const std::string name = fmt::format("limit crossed on purpose, {}", safety::name(c.cause));
            if (stop.trip.cause != c.cause)
                throw DeviceError{name + ": the drive stopped for another cause: " + text(stop.trip)};
            results_.add_stop(name, "the order", stop);
            session_.clear();
        }
        return results_.agreed(
            "ramp", "The drive was stopped four times. Did the base come to rest each time without a knock?");
    }

    bool aborts() {
        const std::array<std::pair<const char*, std::function<void()>>, 3> doors{
            {{"SCPI over TCP", [&] { abort_by_scpi(session_.server().scpi_port()); }},
             {"SCPI on the Unix socket", [&] { abort_by_socket(session_.socket()); }},
             {"HTTP", [&] { abort_by_http(session_.server().http_port()); }}}};
        for (const auto& [door, abort] : doors) {
            session_.drive(full_);
            results_.add_stop(fmt::format("abort by {}", door), "the order", session_.stopped_by(abort));
            session_.clear();
        }
        return true;
    }

    bool emergency_stop() {
        session_.drive(full_);
        return results_.agreed(
            "emergency stop",
            "The drive is on. Press the emergency stop. Is the base at rest within a period?");
    }

    Folder folder_;
    Session session_;
    Drive full_;
    double sheet_ = NAN;  // response by the data sheet, m/s^2 per V
    Results results_;
};

}  // namespace

bool commission(const Settings& settings, const Operator& person) {
    if (settings.rig == "sim:")
        throw InputError{
            "--commission: the simulated bench needs no commissioning; name a rig file by --rig"};
    Day day{settings, person};
    if (!settings.tested_text.empty() && day.rig_text() != settings.tested_text)
        throw InputError{settings.rig + " has changed since its self-test; start the commissioning again"};
    if (!day.lead()) return false;
    commissioned::write_record(settings.rig, day.rig_text(), recording::local_time_text(), day.items());
    person.show("commissioned: " + commissioned::record_of(settings.rig).string() + "\n");
    return true;
}

}  // namespace shaker::commissioning
