#include "tests/orders/simulation.hpp"

#include <spdlog/fmt/fmt.h>
#include <spdlog/spdlog.h>

#include <cmath>
#include <fstream>
#include <utility>

#include "daemon/run/runner.hpp"
#include "daemon/service/bench_service.hpp"
#include "drivers/errors.hpp"
#include "tests/orders/clients.hpp"
#include "tests/orders/kept_data.hpp"
#include "tests/orders/simulated_disk.hpp"
#include "tests/orders/watched_devices.hpp"

namespace shaker::orders {

namespace {

struct Killed {};

constexpr const char* foreign = "a file of another program\n";
constexpr calibration::Estimate known_mu{0.113, 0.001};
constexpr double longest_answer_s = 5;
constexpr double longest_end_s = 5;  // after leave()

run::RunOptions options_of(const Plan& plan, const std::filesystem::path& scene) {
    run::RunOptions run;
    run.scene = scene;
    run.pictures = recorded::KeptPictures::off;
    run.drive.frequency = plan.frequency_hz;
    run.drive.gamma = gamma_for(1. / 7, plan.frequency_hz);
    run.plan.periods = 5;
    run.plan.settle = 3;
    run.identify = plan.identifies;
    return run;
}

double check_level(const run::Sequence& sequence) {
    const control::DriveController& c = sequence.controller();
    const safety::LoopCheck check{{.target = harmonics(c.drive()),
                                   .response = c.response_at(c.drive().frequency),
                                   .identified = c.identified() ? &*c.identified() : nullptr,
                                   .noise = c.noise()}};
    return control::peak(check.volts());
}

/// One life of the program: from its start to its end or to the moment it is killed.
class Life {
public:
    Life(const Plan& plan, double from_s, const std::filesystem::path& folder, Outcome& outcome)
        : plan_{plan},
          from_s_{from_s},
          folder_{folder},
          outcome_{outcome},
          runner_{{.run = options_of(plan, scene_file()), .on_call = true, .recordings = folder}},
          service_{runner_, {.mu = plan.at_edge ? known_mu : calibration::Estimate{NAN, NAN}}, port_},
          laws_{runner_.bench().rig.dac->info(), runner_.bench().rig.accelerometer->info(), shaker_axis(),
                runner_.collector().channels(), runner_.collector().streams()},
          clients_{port_, laws_},
          watch_{.laws = laws_,
                 .troubled = [this](std::size_t trouble) { return lasts(trouble); },
                 .meanwhile = [this] { live(); }} {
        laws_.limits(runner_.limits());
        laws_.has_target(runner_.bench().rig.cameras.front()->view().frame_rate_hz);
        laws_.check_level([this] { return check_level(runner_.sequence()); });
        watch_devices(runner_.bench().rig, watch_);
        while (move_ < plan_.moves.size() && plan_.moves[move_].at_s < from_s_) ++move_;
    }

    /// True when the program was killed.
    bool play() {
        bool killed = false;
        try {
            runner_.lead(
                [this](const acquisition::Streams& s, acquisition::Channels& c) {
                    return !lasts(static_cast<std::size_t>(Trouble::slow_output)) && step(s, c);
                },
                [this] {
                    watch_.heap.begin("output");
                    return service_.done() || overdue();
                });
        } catch (const Killed&) {
            killed = true;
        } catch (const DeviceError& e) {
            laws_.broken("the daemon stays up", e.what());
        }
        watch_.heap.forget();
        set_disk(Disk::good);
        take_counts();
        check_taken_names();
        if (!killed) check_events();
        check_campaigns(killed);
        return killed;
    }
    [[nodiscard]] const Clients& clients() const noexcept { return clients_; }
    [[nodiscard]] const std::filesystem::path& copy() const noexcept { return copy_; }
    [[nodiscard]] double killed_at_s() const noexcept { return killed_at_s_; }

private:
    std::filesystem::path scene_file() {
        std::filesystem::create_directories(folder_);
        std::filesystem::path file = folder_ / "scene.toml";
        std::ofstream{file} << scene_of(plan_, from_s_);
        return file;
    }

    [[nodiscard]] double now_s() const noexcept { return from_s_ + laws_.now_s(); }

    [[nodiscard]] bool lasts(std::size_t trouble) const {
        return std::ranges::any_of(plan_.faults, [&](const Fault& f) {
            return f.trouble == trouble && now_s() >= f.at_s && now_s() < f.at_s + f.for_s;
        });
    }

    // A turn of all threads but that of the output.
    void live() {
        acquisition::Collector& collector = runner_.collector();
        for (acquisition::Loop& loop : collector.sensor_loops())
            while (loop.step(std::chrono::milliseconds{0})) {
            }
        collector.collect();
        step(collector.streams(), collector.channels());
    }

    bool step(const acquisition::Streams& streams, acquisition::Channels& channels) {
        laws_.see_trips();
        begin_faults();
        act();
        bool any = false;
        const bool serves = !lasts(static_cast<std::size_t>(Trouble::slow_service));
        const bool leaves = serves && service_.leaving() && !std::exchange(left_, true);
        if (serves)
            any = service_.step(streams, channels);
        else
            laws_.unwatched();
        if (leaves) laws_.left();
        clients_.turn();
        if (const auto now = port_.state()) {
            const run::RunState before = std::exchange(state_, now->state);
            if (before == run::RunState::self_test && state_ != before && state_ != run::RunState::tripped)
                laws_.self_tested();
            if (state_ == run::RunState::loop_check && state_ != before) laws_.checks();
            if (state_ == run::RunState::identify ||
                (before == run::RunState::loop_check && state_ == run::RunState::ramp))
                laws_.checked();
            laws_.limits(now->limits);
            laws_.may_drive(now->wanted.frequency);
            if (serves) laws_.state(state_);
        }
        if (now_s() > plan_.length_s && !service_.leaving()) {
            service_.leave();
            left_at_s_ = now_s();
        }
        if (serves) clients_.require_answers(longest_answer_s);
        return any;
    }

    void act() {
        for (; move_ < plan_.moves.size() && plan_.moves[move_].at_s <= now_s(); ++move_) {
            outcome_.coverage.action(state_, plan_.moves[move_].action);
            if (plan_.moves[move_].action == Action::recover)
                recover_open_recording();
            else if (plan_.moves[move_].action == Action::same_name)
                take_name_of_recording();
            else
                clients_.act(plan_.moves[move_]);
        }
    }

    // The file that is being recorded; empty: none.
    [[nodiscard]] std::filesystem::path open_recording() const {
        const auto now = port_.state();
        if (!now || now->recording.name.empty()) return {};
        const std::filesystem::path file = folder_ / now->recording.name;
        return std::filesystem::exists(file.string() + ".part") ? file : std::filesystem::path{};
    }

    void recover_open_recording() {
        const std::filesystem::path file = open_recording();
        if (!file.empty() && recovers(file))
            laws_.broken("a recorder keeps its file", file.filename().string());
    }

    void take_name_of_recording() {
        const std::filesystem::path file = open_recording();
        if (file.empty() || std::filesystem::exists(file)) return;
        std::ofstream{file} << foreign;
        taken_.push_back(file);
    }

    void check_taken_names() {
        for (const std::filesystem::path& file : taken_) {
            std::ifstream in{file};
            const std::string now{std::istreambuf_iterator<char>{in}, {}};
            if (now != foreign) laws_.broken("no file is replaced", file.filename().string());
        }
    }

    void begin_faults() {
        for (std::size_t i = 0; i < plan_.faults.size(); ++i) {
            const Fault& f = plan_.faults[i];
            if (begun_.at(i) || f.at_s < from_s_ || now_s() < f.at_s) continue;
            begun_[i] = true;
            outcome_.coverage.fault(state_, f.trouble, f.at_s);
            if (f.trouble == static_cast<std::size_t>(simulated::FaultKind::contact_open))
                laws_.contact_opened();
            if (f.trouble == static_cast<std::size_t>(Trouble::killed)) die();
        }
        Disk disk = Disk::good;
        if (lasts(static_cast<std::size_t>(Trouble::disk_error))) disk = Disk::failing;
        if (lasts(static_cast<std::size_t>(Trouble::disk_full))) disk = Disk::full;
        set_disk(disk);
    }

    // What the program has written until now stays; what it would write while it is destroyed does not count.
    void die() {
        killed_at_s_ = now_s();
        set_disk(Disk::good);
        copy_ = folder_;
        copy_ += "-after-kill";
        std::filesystem::copy(folder_, copy_, std::filesystem::copy_options::recursive);
        throw Killed{};
    }

    bool overdue() {
        if (left_at_s_ < 0 || now_s() < left_at_s_ + longest_end_s) return false;
        laws_.broken("the daemon ends",
                     fmt::format("state {} {} s after the request to end", name(state_), longest_end_s));
        return true;
    }

    void check_events() {
        for (const service::BenchEvent& e : port_.events(0)) {
            if (e.kind != "note" || !e.text.starts_with("recorded: ")) continue;
            const std::filesystem::path file = e.text.substr(std::string{"recorded: "}.size());
            ++outcome_.recordings;
            for (const std::string& why : faults_of(file)) laws_.broken("what was recorded is kept", why);
            outcome_.replayed += 1;
        }
    }

    void check_campaigns(bool killed) {
        const bool disk_works = std::ranges::none_of(plan_.faults, [](const Fault& f) {
            return f.trouble == static_cast<std::size_t>(Trouble::disk_full) ||
                   f.trouble == static_cast<std::size_t>(Trouble::disk_error);
        });
        for (const std::string& why : faults_of_campaigns(folder_, !killed && disk_works))
            laws_.broken("what a campaign writes is read", why);
    }

    void take_counts() {
        for (const service::BenchEvent& e : port_.events(0)) {
            outcome_.log.push_back(fmt::format("{:8.3f} s {}: {}", from_s_ + e.t_s, e.kind, e.text));
            if (e.text.starts_with("internal error")) laws_.broken("only allowed changes of state", e.text);
        }
        outcome_.virtual_s += laws_.now_s();
        outcome_.aborts += laws_.aborts();
        outcome_.trips += laws_.trips();
        outcome_.slowest_abort_s = std::max(outcome_.slowest_abort_s, laws_.slowest_abort_s());
        outcome_.fingerprint = outcome_.fingerprint * 31 + laws_.fingerprint();
    }

public:
    void take_violations() {
        for (const Violation& v : laws_.violations()) {
            outcome_.violations.push_back(v);
            outcome_.violations.back().at_s += from_s_;
        }
    }

private:
    const Plan& plan_;
    double from_s_;
    std::filesystem::path folder_;
    Outcome& outcome_;
    run::Runner runner_;
    service::BenchPort port_;
    service::BenchService service_;
    Laws laws_;
    Clients clients_;
    Watch watch_;
    std::size_t move_ = 0;
    std::vector<bool> begun_ = std::vector<bool>(plan_.faults.size());
    run::RunState state_ = run::RunState::init;
    double left_at_s_ = -1, killed_at_s_ = 0;
    bool left_ = false;  // the service has made a step since leave()
    std::filesystem::path copy_;
    std::vector<std::filesystem::path> taken_{};  // names that another program took
};

}  // namespace

Outcome simulate(const Plan& plan, const std::filesystem::path& folder) {
    Outcome outcome;
    const std::size_t open_before = left_open();
    double from_s = 0;
    std::filesystem::path now = folder / "life-1";
    for (int life = 1;; ++life) {
        std::filesystem::path copy;
        bool killed = false;
        std::vector<std::pair<double, std::string>> remarks;
        {
            Life present{plan, from_s, now, outcome};
            killed = present.play();
            present.take_violations();
            copy = present.copy();
            if (killed) from_s = present.killed_at_s();
            remarks = present.clients().remarks();
        }
        if (const std::size_t open = left_open(); open > open_before)
            outcome.violations.push_back(
                {"files are closed", from_s, fmt::format("{} are still open", open - open_before)});
        if (!killed) return outcome;
        for (const std::string& why : lost_after_kill(copy, remarks))
            outcome.violations.push_back({"what was recorded is kept", from_s, why});
        ++outcome.recovered;
        now = folder / fmt::format("life-{}", life + 1);
    }
}

}  // namespace shaker::orders
