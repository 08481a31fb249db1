#include "daemon/commissioning/commission.hpp"

#include <spdlog/fmt/fmt.h>
#include <stdlib.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <istream>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

#include "calibration/accelerometer/sensor_file.hpp"
#include "daemon/commissioning/session.hpp"
#include "daemon/recording/time_text.hpp"
#include "drivers/commissioned/record.hpp"
#include "drivers/drive.hpp"
#include "drivers/errors.hpp"
#include "drivers/mixer/mixer.hpp"

#include <boost/asio/connect.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/local/stream_protocol.hpp>
#include <boost/asio/read_until.hpp>
#include <boost/asio/streambuf.hpp>
#include <boost/asio/write.hpp>

namespace shaker::commissioning {

namespace asio = boost::asio;

namespace {

using commissioned::Item;
using safety::Cause;

// Results of the tests so far, and the operator to whom they are shown.
class Results {
public:
    /// person: outlives this object. before: results that the operator has seen.
    Results(const Operator& person, std::vector<Item> before) : person_{person}, items_{std::move(before)} {}

    void add(const std::string& name, const std::string& result);
    /// Adds a stop by `what`. DeviceError when it took too long.
    void add_stop(const std::string& name, const std::string& what, const SeenStop& stop,
                  const std::string& more = {});
    /// Asks the operator and adds the confirmation. False, with the reason shown, when it is denied.
    bool agreed(const std::string& name, const std::string& question);
    /// Adds a result of an earlier day, unless there is a new one of this name.
    void keep(const Item& item);
    void show(const std::string& text) const { person_.show(text); }
    [[nodiscard]] const std::vector<Item>& items() const noexcept { return items_; }

private:
    const Operator& person_;
    std::vector<Item> items_;
};

constexpr double longest_stop_s = 1;

void Results::add(const std::string& name, const std::string& result) {
    person_.show(fmt::format("ok   {}: {}\n", name, result));
    items_.push_back({name, result});
}

void Results::keep(const Item& item) {
    if (std::ranges::find(items_, item.name, &Item::name) == items_.end()) items_.push_back(item);
}

void Results::add_stop(const std::string& name, const std::string& what, const SeenStop& stop,
                       const std::string& more) {
    const std::string seen = fmt::format("stopped {:.0f} ms after {}, ramp of {:.1f} ms", 1e3 * stop.after_s,
                                         what, 1e3 * stop.ramp_s);
    if (stop.after_s > longest_stop_s) throw DeviceError{name + ": " + seen};
    add(name, seen + more);
}

bool Results::agreed(const std::string& name, const std::string& question) {
    const std::string answer = person_.ask(question + " [y/n] ");
    person_.rethrow();
    if (answer == "y") {
        add(name, "confirmed by the operator");
        return true;
    }
    person_.show(fmt::format("BAD  {}: not confirmed; no record was written\n", name));
    return false;
}

// The operator confirms that the amplifier is off at rest, switches on before the drive and off after it.
// False when the operator denies it; true without a test when the rig has no enable output. Leaves the bench
// idle.
bool enable_output(Session& session, const Drive& drive, Results& results) {
    const Rig& rig = session.bench().rig;
    if (rig.dac->info().enable_before_s <= 0) return true;
    if (!results.agreed("enable output, at rest",
                        "The drive is off, and so is the enable output. Is the amplifier switched off?"))
        return false;
    results.show("Watch the amplifier: the drive starts now and stops after some seconds.\n");
    session.drive(drive);
    session.end();
    return results.agreed("enable output, with the drive",
                          "The drive has stopped. Did the amplifier switch on before the base moved, and off "
                          "after the base came to rest?");
}

// The operator opens the contact while the bench drives. The stop is timed from the reading of the open
// contact. Checks that a clear is refused while the contact is open and that closing it clears nothing.
// DeviceError otherwise. Without a test when the rig has no abort input. Leaves the bench idle.
void abort_input(Session& session, const Drive& drive, Results& results) {
    if (!session.bench().rig.abort_input) return;
    const std::string name = "abort input";
    session.drive(drive);
    const SeenStop stop = session.stopped_by_contact([&] {
        results.show(
            "The drive is on. Open the contact of the abort input within a minute, and keep it open.\n");
    });
    if (stop.trip.cause != Cause::abort_input)
        throw DeviceError{name + ": the drive stopped for another cause: " + text(stop.trip)};
    const std::string refused = session.refused_clear();
    if (!session.contact_open())
        throw DeviceError{name +
                          ": the contact closed before a clear was tried; commission the bench again and "
                          "keep the contact open"};
    if (refused.empty()) throw DeviceError{name + ": a clear was accepted while the contact was open"};
    results.show("Close the contact within a minute.\n");
    if (!session.stays_tripped_when_closed())
        throw DeviceError{name + ": the trip was cleared by the contact that closed"};
    results.add_stop(name, "the contact opened", stop, "; a clear was refused: " + refused);
    session.clear();
}

// The first line of the answer.
template <class Socket>
std::string ask(Socket& socket, const std::string& request) {
    asio::write(socket, asio::buffer(request));
    asio::streambuf answer;
    asio::read_until(socket, answer, '\n');
    std::istream in{&answer};
    std::string line;
    std::getline(in, line);
    return line;
}

void require(const std::string& answer, const std::string& wanted) {
    if (answer.find(wanted) == std::string::npos)
        throw DeviceError{"an abort was answered by \"" + answer + "\", not by " + wanted};
}

asio::ip::tcp::socket connected(asio::io_context& io, int port) {
    asio::ip::tcp::socket socket{io};
    socket.connect({asio::ip::address_v4::loopback(), static_cast<std::uint16_t>(port)});
    return socket;
}

// Each function aborts over a new connection to this computer and returns when the daemon has acknowledged
// that the output obeys. DeviceError when it does not.
void abort_by_scpi(int port) {
    asio::io_context io;
    asio::ip::tcp::socket socket = connected(io, port);
    require(ask(socket, "ABOR?\n"), "1");
}

void abort_by_socket(const std::filesystem::path& path) {
    asio::io_context io;
    asio::local::stream_protocol::socket socket{io};
    socket.connect(asio::local::stream_protocol::endpoint{path.string()});
    require(ask(socket, "ABOR?\n"), "1");
}

void abort_by_http(int port) {
    asio::io_context io;
    asio::ip::tcp::socket socket = connected(io, port);
    require(ask(socket, "POST /api/abort HTTP/1.1\r\nHost: localhost\r\nContent-Length: 0\r\n\r\n"), "200");
}

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
    /// Only what a new calibration of the same sensor can change; the other items are those of `before`.
    void lead_again(const std::vector<Item>& before, const std::string& change) {
        results_.add("accelerometer calibrated again", change);
        step();
        for (const Item& item : before) results_.keep(item);
    }
    [[nodiscard]] commissioned::Record record() {
        return {.date = recording::local_time_text(),
                .rig_sha256 = commissioned::rig_hash(rig_text()),
                .files = session_.bench().files,
                .items = results_.items()};
    }
    /// The rig file as it was opened.
    [[nodiscard]] const std::string& rig_text() { return session_.bench().rig_text; }

private:
    bool polarity() {
        return results_.agreed(
            "polarity by hand",
            "Push the base by hand towards +x of the rig file. Does it move along the key `along` in every "
            "picture, and along `shaker_axis` of the accelerometer?");
    }

    bool gain() {
        const double peak_V = step();
        return results_.agreed(
            "voltage at the output",
            fmt::format("The drive is on. A true-RMS meter at output 1 must show {:.4g} V, within 5 %. "
                        "Does it?",
                        peak_V / std::numbers::sqrt2));
    }

    // A step of the drive to twice its level. Returns the peak of the higher one, V.
    double step() {
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
        return high.volts_peak;
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

constexpr double least_change = 0.05;  // of a gain, that needs the whole day again

/// The record of an earlier day; empty when there is none or it cannot be read: the whole day replaces it.
std::optional<commissioned::Record> earlier(const std::string& rig) try {
    return commissioned::read_record(rig);
} catch (const InputError&) {
    return std::nullopt;
}

/// The change, when only the accelerometer was calibrated again and its gains moved less than 5 %; else
/// empty. A record of an earlier version has no mixers.
std::string recalibrated(const commissioned::Record& before, const commissioned::Record& now) try {
    const auto is_mixer = [](const commissioned::Named& file) {
        return file.what.starts_with(commissioned::mixer_of);
    };
    const auto others = [&](const commissioned::Record& of) {
        return std::ssize(of.files) - std::ranges::count_if(of.files, is_mixer);
    };
    if (before.rig_sha256 != now.rig_sha256 || others(before) != others(now)) return {};
    std::string change;
    for (const commissioned::Named& b : now.files) {
        const auto found = std::ranges::find(before.files, b.what, &commissioned::Named::what);
        if (is_mixer(b) && (found == before.files.end() || mixer_changes(found->text, b.text).empty()))
            continue;
        if (found == before.files.end()) return {};
        const commissioned::Named& a = *found;
        if (a == b) continue;
        if (a.what != "calibration of accelerometer") return {};
        const auto then = calibration::parse_calibration(a.text, "record"),
                   since = calibration::parse_calibration(b.text, "calibration");
        if (then.sensor != since.sensor) return {};
        double largest = 0, moved = 0;
        for (std::size_t k = 0; k < 3; ++k)
            for (std::size_t m = 0; m < 3; ++m) {
                largest = std::max(largest, std::abs(then.fit.gain[k][m]));
                moved = std::max(moved, std::abs(since.fit.gain[k][m] - then.fit.gain[k][m]));
            }
        if (!(moved < least_change * largest)) return {};
        change = fmt::format("gains moved by {:.2f} % at most since {}", 100 * moved / largest, then.date);
    }
    return change;
} catch (const InputError&) {
    return {};  // a calibration of the record that cannot be read
}

}  // namespace

bool commission(const Settings& settings, const Operator& person) {
    if (settings.rig == "sim:")
        throw InputError{
            "--commission: the simulated bench needs no commissioning; name a rig file by --rig"};
    Day day{settings, person};
    if (!settings.tested_text.empty() && day.rig_text() != settings.tested_text)
        throw InputError{settings.rig + " has changed since its self-test; start the commissioning again"};
    const auto before = earlier(settings.rig);
    const std::string change = before ? recalibrated(*before, day.record()) : "";
    if (!change.empty())
        day.lead_again(before->items, change);
    else if (!day.lead())
        return false;
    commissioned::write_record(settings.rig, day.record());
    person.show("commissioned: " + commissioned::record_of(settings.rig).string() + "\n");
    return true;
}

}  // namespace shaker::commissioning
