#include "daemon/commissioning/commission.hpp"

#include <spdlog/fmt/fmt.h>
#include <stdlib.h>

#include <array>
#include <cmath>
#include <numbers>

#include "daemon/commissioning/doors.hpp"
#include "daemon/commissioning/session.hpp"
#include "daemon/recording/time_text.hpp"
#include "drivers/commissioned/record.hpp"
#include "drivers/errors.hpp"

namespace shaker::commissioning {

namespace {

using commissioned::Item;
using safety::Cause;

// The friction of the walker changes the load and adds harmonics to the peak of the drive.
constexpr double step_tolerance = 0.2;
constexpr double sheet_factor = 1.5, longest_stop_s = 1;

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
        : settings_{settings},
          person_{person},
          session_{settings.rig, {.frequency = settings.frequency_hz}, folder_.path, person.rethrow} {
        items_.push_back({"self-test", settings.self_test});
        DacInfo dac = session_.bench().rig.dac->info();
        sheet_ = std::abs(session_.bench().response(settings.frequency_hz));
        full_ = {.frequency = settings.frequency_hz,
                 .gamma = settings.level * dac.full_scale_V * sheet_,
                 .rho = 1};
    }

    bool lead() {
        return agreed("polarity by hand",
                      "Push the base by hand towards +x of the rig file. Does it move along the key `along` "
                      "in every "
                      "picture, and along `shaker_axis` of the accelerometer?") &&
               gain() && limits() && aborts() && emergency_stop();
    }
    [[nodiscard]] const std::vector<Item>& items() const { return items_; }

private:
    void add(const std::string& name, const std::string& result) {
        person_.show(fmt::format("ok   {}: {}\n", name, result));
        items_.push_back({name, result});
    }
    bool agreed(const std::string& name, const std::string& question) {
        const std::string answer = person_.ask(question + " [y/n] ");
        person_.rethrow();
        if (answer == "y") {
            add(name, "confirmed by the operator");
            return true;
        }
        person_.show(fmt::format("BAD  {}: not confirmed; no record was written\n", name));
        return false;
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
        add("gain by a known step", seen);
        return agreed(
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
            safety::Limits lowered = session_.limits();
            lowered.*c.level = {c.present / 4, c.present / 2};
            const SeenStop stop = session_.stopped_by([&] { session_.order(service::LowerLimits{lowered}); });
            const std::string name = fmt::format("limit crossed on purpose, {}", safety::name(c.cause));
            if (stop.trip.cause != c.cause)
                throw DeviceError{name + ": the drive stopped for another cause: " + text(stop.trip)};
            add_stop(name, stop);
            session_.clear();
        }
        return agreed(
            "ramp", "The drive was stopped four times. Did the base come to rest each time without a knock?");
    }

    bool aborts() {
        const std::array<std::pair<const char*, std::function<void()>>, 3> doors{
            {{"SCPI over TCP", [&] { abort_by_scpi(session_.server().scpi_port()); }},
             {"SCPI on the Unix socket", [&] { abort_by_socket(session_.socket()); }},
             {"HTTP", [&] { abort_by_http(session_.server().http_port()); }}}};
        for (const auto& [door, abort] : doors) {
            session_.drive(full_);
            add_stop(fmt::format("abort by {}", door), session_.stopped_by(abort));
            session_.clear();
        }
        return true;
    }

    bool emergency_stop() {
        session_.drive(full_);
        return agreed("emergency stop",
                      "The drive is on. Press the emergency stop. Is the base at rest within a period?");
    }

    void add_stop(const std::string& name, const SeenStop& stop) {
        const std::string seen = fmt::format("stopped {:.0f} ms after the order, ramp of {:.1f} ms",
                                             1e3 * stop.after_s, 1e3 * stop.ramp_s);
        if (stop.after_s > longest_stop_s) throw DeviceError{name + ": " + seen};
        add(name, seen);
    }

    const Settings& settings_;
    const Operator& person_;
    Folder folder_;
    Session session_;
    Drive full_;
    double sheet_ = NAN;  // response by the data sheet, m/s^2 per V
    std::vector<Item> items_;
};

}  // namespace

bool commission(const Settings& settings, const Operator& person) {
    if (settings.rig == "sim:")
        throw InputError{
            "--commission: the simulated bench needs no commissioning; name a rig file by --rig"};
    Day day{settings, person};
    if (!day.lead()) return false;
    commissioned::write_record(settings.rig, recording::local_time_text(), day.items());
    person.show("commissioned: " + commissioned::record_of(settings.rig).string() + "\n");
    return true;
}

}  // namespace shaker::commissioning
