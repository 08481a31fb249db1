#include "daemon/commissioning/session.hpp"

#include <cmath>
#include <future>

#include "drivers/errors.hpp"
#include "drivers/time.hpp"

namespace shaker::commissioning {

namespace {

constexpr double patience_s = 60;
constexpr double follows = 0.02;  // largest relative error of the motion that follows its set-point
constexpr int periods = 20;       // of a measurement

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point begin) {
    return std::chrono::duration<double>{Clock::now() - begin}.count();
}

run::RunnerSettings settings_for(const std::string& rig, const Drive& drive,
                                 const std::filesystem::path& folder) {
    run::RunOptions run;
    run.rig = rig;
    run.drive = drive;
    run.pictures = recorded::KeptPictures::off;
    run.threads = run.real_time = true;
    return {.run = run, .on_call = true, .recordings = folder, .commissioning = true};
}

}  // namespace

Session::Session(const std::string& rig, const Drive& drive, const std::filesystem::path& folder,
                 std::function<void()> rethrow, const std::function<void(Rig&)>& fit)
    : runner_{settings_for(rig, drive, folder)},
      service_{runner_, {}, port_},
      socket_{folder / "scpi"},
      drive_{drive},
      rethrow_{std::move(rethrow)} {
    Rig& devices = runner_.bench().rig;
    if (fit) fit(devices);
    if (devices.abort_input)
        devices.abort_input = std::make_unique<WatchedContact>(std::move(devices.abort_input), contact_);
    server_ = std::make_unique<remote::Server>(
        port_, remote::ServerSettings{.http_port = 0, .scpi_port = 0, .scpi_socket = socket_});
    leader_ = std::jthread{[this] { lead(); }};
    wait_for("the bench is idle",
             [](const service::BenchState& s) { return s.state == run::RunState::idle; });
}

Session::~Session() {
    service_.leave();
    leader_.join();
}

void Session::lead() {
    try {
        runner_.lead(
            [this](const acquisition::Streams& streams, acquisition::Channels& channels) {
                if (!streams.changes.empty() && streams.changes.back().stop > 0)
                    ramp_ = streams.changes.back().stop;
                return service_.step(streams, channels);
            },
            [this] { return service_.done(); });
    } catch (...) {
        const std::scoped_lock lock{mutex_};
        ended_ = std::current_exception();
    }
}

std::shared_ptr<const service::BenchState> Session::wait_for(
    const std::string& what, const std::function<bool(const service::BenchState&)>& seen) {
    for (const auto begin = Clock::now(); seconds_since(begin) < patience_s;) {
        if (const auto state = port_.state(); state && seen(*state)) return state;
        rethrow_();
        {
            const std::scoped_lock lock{mutex_};
            if (ended_) std::rethrow_exception(ended_);
        }
        std::this_thread::sleep_for(std::chrono::milliseconds{1});
    }
    const auto state = port_.state();
    throw DeviceError{"not within a minute: " + what +
                      (state && state->trip ? "; " + text(*state->trip) : std::string{})};
}

std::shared_ptr<const service::BenchState> Session::wait_a_second() {
    const auto begin = Clock::now();
    return wait_for("a second passes",
                    [begin](const service::BenchState&) { return seconds_since(begin) > 1; });
}

std::string Session::answer_to(const service::OrderWhat& what) {
    const auto answer = std::make_shared<std::promise<std::string>>();
    auto refused = answer->get_future();
    port_.order({what, [answer](const std::string& why) { answer->set_value(why); }});
    if (refused.wait_for(std::chrono::duration<double>{patience_s}) != std::future_status::ready)
        throw DeviceError{"the bench does not answer"};
    return refused.get();
}

void Session::order(const service::OrderWhat& what) {
    if (const std::string why = answer_to(what); !why.empty()) throw DeviceError{why};
}

std::shared_ptr<const service::BenchState> Session::drive(const Drive& drive) {
    order(service::SetDrive{drive});
    drive_ = drive;
    if (port_.state()->state != run::RunState::run) order(service::Begin{periods});
    const auto ordered = Clock::now();
    return wait_for("the base follows the drive", [&](const service::BenchState& s) {
        if (s.state == run::RunState::tripped) throw DeviceError{"the drive stopped: " + text(*s.trip)};
        return s.locked && s.base && seconds_since(ordered) > 2 &&
               std::abs(s.base->got.gamma / drive.gamma - 1) < follows;
    });
}

SeenStop Session::stopped_by(const std::function<void()>& stop) {
    const auto begin = Clock::now();
    return seen_stop(stop, [begin] { return begin; });
}

SeenStop Session::stopped_by_contact(const std::function<void()>& ask) {
    contact_.restart();
    return seen_stop(ask, [this] { return contact_.opened_at(); });
}

SeenStop Session::seen_stop(const std::function<void()>& stop,
                            const std::function<Clock::time_point()>& began) {
    ramp_ = 0;
    stop();
    const auto state = wait_for("the drive stops", [&](const service::BenchState& s) {
        return s.state == run::RunState::tripped && s.trip;
    });
    const double after_s = seconds_since(began());
    wait_for("the ramp to zero is played", [&](const service::BenchState&) { return ramp_ > 0; });
    const double rate_hz = runner_.bench().rig.dac->info().rate_hz;
    return {*state->trip, after_s, duration_s(ramp_, rate_hz)};
}

void Session::end() {
    order(service::End{});
    wait_for("the drive has stopped",
             [](const service::BenchState& s) { return s.state == run::RunState::idle; });
    wait_a_second();
}

std::string Session::refused_clear() {
    wait_for("the trip can be cleared", [](const service::BenchState& s) { return s.may_clear; });
    return answer_to(service::ClearTrip{});
}

bool Session::stays_tripped_when_closed() {
    wait_for("the contact is closed", [&](const service::BenchState&) { return !contact_open(); });
    return wait_a_second()->state == run::RunState::tripped;
}

void Session::clear() {
    if (const std::string why = refused_clear(); !why.empty()) throw DeviceError{why};
    wait_for("the bench is idle again",
             [](const service::BenchState& s) { return s.state == run::RunState::idle; });
    order(service::Adopt{drive_, {.periods = periods}, runner_.limits(), true});
}

}  // namespace shaker::commissioning
