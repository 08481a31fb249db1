// Time from an order to stop to silence, in virtual time, in every state of a run and of a campaign's start:
// the drive must not rise after the order.
//   --seeds N (3): the order comes at random times of the state
#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <fstream>
#include <random>
#include <string>

#include "daemon/campaign/lead/plans.hpp"
#include "daemon/run/run_setup.hpp"
#include "daemon/service/bench_service.hpp"
#include "tests/bench/option.hpp"
#include "tests/bench/table.hpp"
#include "tests/support/program.hpp"
#include "tests/support/run/bench_on_call.hpp"

namespace {

using namespace shaker;
using run::RunState;
using service::BenchState;

constexpr double silence_V = 1e-6;
constexpr double whole_periods = 40;  // of the drive, in which an identification shows its largest peak

/// Peaks of the blocks that are written.
class PeakDac final : public Dac {
public:
    explicit PeakDac(std::unique_ptr<Dac> inner) : inner_{std::move(inner)} {}
    [[nodiscard]] DacInfo info() const override { return inner_->info(); }
    [[nodiscard]] DeviceCounts counts() const noexcept override { return inner_->counts(); }
    PlayTime write(std::span<const double> volts, std::span<const double> trigger) override {
        double peak = 0;
        for (const double v : volts) peak = std::max(peak, std::abs(v));
        written_s += static_cast<double>(volts.size()) / inner_->info().rate_hz;
        blocks.push_back({written_s, peak});
        return inner_->write(volts, trigger);
    }
    void stop() noexcept override { inner_->stop(); }

    struct Block {
        double until_s, peak_V;
    };
    std::deque<Block> blocks{};
    double written_s = 0;

private:
    std::unique_ptr<Dac> inner_;
};

/// The moment of the order.
struct Moment {
    std::string name;
    bool campaign;
    bool (*reached)(const BenchState&);
};

template <RunState wanted>
bool in(const BenchState& s) {
    return s.state == wanted;
}

const std::vector<Moment>& moments() {
    static const std::vector<Moment> all = [] {
        std::vector<Moment> of_both;
        for (const bool campaign : {false, true}) {
            of_both.push_back({"identify", campaign, in<RunState::identify>});
            of_both.push_back({"loop check", campaign, in<RunState::loop_check>});
            of_both.push_back({"ramp", campaign, in<RunState::ramp>});
            of_both.push_back({"settle", campaign,
                               [](const BenchState& s) { return s.state == RunState::run && !s.measuring; }});
            of_both.push_back({"measure", campaign, [](const BenchState& s) { return s.measuring; }});
        }
        return of_both;
    }();
    return all;
}

struct Stop {
    bool reached = false;
    std::string answer;
    double before_V = 0, after_V = 0, to_silence_s = NAN;
};

/// gamma as large as the limits allow, at most 1 g.
Drive drive_at(double frequency, const bench::Bench& bench) {
    Drive drive;
    drive.frequency = frequency;
    drive.gamma = 1;
    double most = paper_g;
    for (const safety::Demand& d : run::run_demands(bench, drive, bench.limits))
        most = std::min(most, 0.8 * d.limit / d.value);
    drive.gamma = most;
    return drive;
}

Stop stop(const Moment& moment, double frequency, unsigned seed, const std::filesystem::path& folder) {
    std::filesystem::create_directories(folder);
    std::ofstream{folder / "scene.toml"} << test::slow;
    run::RunOptions options = test::quick();
    options.scene = folder / "scene.toml";
    options.drive.frequency = frequency;
    options.drive.gamma = 0.01;
    options.identify = moment.name == "identify" || (moment.campaign && moment.name != "loop check");
    options.drive =
        drive_at(frequency, run::Runner{{.run = options, .on_call = true, .recordings = folder}}.bench());
    run::Runner runner{{.run = options, .on_call = true, .recordings = folder}};
    auto watched = std::make_unique<PeakDac>(std::move(runner.bench().rig.dac));
    PeakDac& dac = *watched;
    runner.bench().rig.dac = std::move(watched);
    service::BenchPort port;
    service::BenchService session{runner, {.mu = {0.113, 0.001}}, port};
    std::mt19937 draw{seed};
    // An identification shows its largest peak in 40 periods.
    const double wait_s = (moment.name == "identify" ? 40 : 0) / frequency +
                          std::uniform_real_distribution{0.0, 5 / frequency}(draw),
                 period_s = 1 / frequency;
    Stop result;
    bool begun = false, ordered = false;
    double reached_s = INFINITY, accepted_s = INFINITY, last_V_s = 0;
    const auto follow = [&](const BenchState& s) {
        if (!begun && s.state == RunState::idle && s.answered == port.ordered()) {
            begun = true;
            if (moment.campaign)
                port.order({service::MeasurePlan{"stop", campaign::text_of({.phi = false,
                                                                            .from = options.drive.gamma / 2,
                                                                            .to = options.drive.gamma,
                                                                            .rest = options.drive,
                                                                            .periods = 10})},
                            [&](const std::string& why) { result.answer += why; }});
            else
                port.order(
                    {service::Begin{{.periods = 10}}, [&](const std::string& why) { result.answer += why; }});
        }
        if (!result.reached && moment.reached(s)) {
            result.reached = true;
            reached_s = dac.written_s;
        }
        if (result.reached && !ordered && dac.written_s >= reached_s + wait_s && moment.reached(s)) {
            ordered = true;
            port.order({service::End{}, [&](const std::string& why) {
                            result.answer += why;
                            for (const PeakDac::Block& b : dac.blocks)
                                if (b.until_s > dac.written_s - whole_periods * period_s)
                                    result.before_V = std::max(result.before_V, b.peak_V);
                            accepted_s = last_V_s = dac.written_s;
                            dac.blocks.clear();
                        }});
        }
    };
    runner.lead(
        [&](const acquisition::Streams& streams, acquisition::Channels& channels) {
            const bool any = session.step(streams, channels);
            follow(*port.state());
            if (!ordered)
                while (dac.blocks.size() > 100'000) dac.blocks.pop_front();
            const bool late = dac.written_s > 300 / std::min(1.0, frequency / 10);
            const bool over = !result.answer.empty() || late || dac.written_s > accepted_s + 4;
            if (over && !session.leaving()) session.leave();
            return any;
        },
        [&] { return session.done(); });
    if (!ordered) return result;
    // The peak of a period may come up to a period after the order without any growth.
    for (const PeakDac::Block& b : dac.blocks) {
        if (b.peak_V <= silence_V) continue;
        last_V_s = b.until_s;
        double& peak_V = b.until_s < accepted_s + period_s ? result.before_V : result.after_V;
        peak_V = std::max(peak_V, b.peak_V);
    }
    result.to_silence_s = last_V_s - accepted_s;
    return result;
}

bench::Row row(const Moment& moment, double frequency, int seeds, const std::filesystem::path& folder) {
    Stop worst;
    double rise = 0, slowest_s = 0, before_V = 0;
    int reached = 0;
    std::string answer;
    for (int seed = 1; seed <= seeds; ++seed) {
        const Stop s = stop(moment, frequency, static_cast<unsigned>(seed), folder / std::to_string(seed));
        std::filesystem::remove_all(folder / std::to_string(seed));
        if (!s.answer.empty()) answer = s.answer;
        if (!s.reached) continue;
        ++reached;
        rise = std::max(rise, s.before_V > 0 ? s.after_V / s.before_V : s.after_V > 0 ? INFINITY : 0);
        slowest_s = std::max(slowest_s, s.to_silence_s);
        before_V = std::max(before_V, s.before_V);
    }
    const double allowed_s = run::longest_soft_stop_s + 0.02;
    return {{"order to stop in", moment.name},
            {"of", moment.campaign ? "a campaign" : "a run"},
            {"frequency", frequency, "Hz"},
            {"reached", fmt::format("{} of {}", reached, seeds)},
            {"largest until a period after", before_V, "V", 3},
            {"later / until then", rise, "", 3},
            {"to silence, slowest", slowest_s, "s", 3},
            {"allowed", allowed_s, "s", 3},
            {"verdict", !answer.empty()                          ? answer
                        : reached == 0                           ? "not reached"
                        : rise <= 1.02 && slowest_s <= allowed_s ? "good"
                                                                 : "wrong"}};
}

}  // namespace

int main(int argc, char** argv) {
    const std::filesystem::path folder = bench::own_folder(argc, argv, "shakerd-stops");
    const int seeds = bench::whole_option(argc, argv, "--seeds", 3, 1);
    bench::Table table;
    for (const double frequency : {1.0, 5.0, 20.0})
        for (const Moment& moment : moments()) table.add(row(moment, frequency, seeds, folder));
    std::filesystem::remove_all(folder);
    table.print(argc, argv);
}
