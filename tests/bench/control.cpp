// Closed loop on the simulated shaker: time to reach the set-point and error after that, for our law and the
// two usual ones on the same plants and seeds. The true motion of the base is the reference.
//   --seeds N (8)   --case WORDS (all)
#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <cstring>
#include <string>
#include <thread>

#include "tests/bench/table.hpp"
#include "tests/support/control/control_bench.hpp"

namespace {

using namespace shaker;
using test::ControlCase;
using test::ControlResult;

std::string option(int argc, char** argv, const char* name, const char* otherwise) {
    for (int i = 1; i + 1 < argc; ++i)
        if (std::strcmp(argv[i], name) == 0) return argv[i + 1];
    return otherwise;
}

std::vector<ControlResult> run_seeds(const ControlCase& c, const test::MakeLaw& make, std::size_t seeds) {
    std::vector<ControlResult> results(seeds);
    std::atomic<std::size_t> next{0};
    std::vector<std::jthread> workers;
    for (unsigned k = 0; k < std::max(1U, std::thread::hardware_concurrency()); ++k)
        workers.emplace_back([&] {
            for (std::size_t i = next++; i < seeds; i = next++)
                results[i] = test::run_control(c, make, i + 1);
        });
    workers.clear();
    return results;
}

// Median and largest; a seed that never locks counts as infinite.
std::string spread(const std::vector<ControlResult>& r, int ControlResult::*lock) {
    std::vector<int> n;
    n.reserve(r.size());
    for (const auto& one : r) n.push_back(one.*lock < 0 ? 1'000'000 : one.*lock);
    std::ranges::sort(n);
    const auto text = [](int v) { return v >= 1'000'000 ? std::string{"never"} : std::to_string(v); };
    return text(n[n.size() / 2]) + " / " + text(n.back());
}

double worst(const std::vector<ControlResult>& r, double ControlResult::*what) {
    double w = -1e9;
    for (const auto& one : r) w = std::max(w, one.*what);
    return w;
}

}  // namespace

int main(int argc, char** argv) {
    const auto seeds =
        static_cast<std::size_t>(std::max(1, std::atoi(option(argc, argv, "--seeds", "8").c_str())));
    const std::string only = option(argc, argv, "--case", "");
    const std::pair<const char*, test::MakeLaw> laws[] = {{"shakerd", test::hybrid()},
                                                          {"integral 0.15", test::integral(0.15)},
                                                          {"time waveform 0.5", test::time_waveform(0.5)}};
    bench::Table table;
    for (const ControlCase& c : test::control_cases()) {
        if (c.name.find(only) == std::string::npos) continue;
        for (const auto& [name, make] : laws) {
            const std::vector<ControlResult> r = run_seeds(c, make, seeds);
            double delta = 0, least = 1;
            int gave_up = 0;
            for (const auto& one : r) {
                delta = std::max(delta, std::abs(one.delta_mrad));
                least = std::min(least, one.reached);
                gave_up += one.gave_up ? 1 : 0;
            }
            table.add({{"case", c.name},
                       {"law", name},
                       {"lock -60 dB med / max", spread(r, &ControlResult::lock60), "periods"},
                       {"lock -80 dB med / max", spread(r, &ControlResult::lock80), "periods"},
                       {"worst mean of 100", worst(r, &ControlResult::mean_db), "dB"},
                       {"worst rms of one", worst(r, &ControlResult::rms_db), "dB"},
                       {"tail 9..16", worst(r, &ControlResult::tail_db), "dB"},
                       {"error of phi", delta, "mrad", 2},
                       {"gamma reached", least, "", 3},
                       {"gave up", std::to_string(gave_up) + " of " + std::to_string(seeds)}});
        }
    }
    table.print(argc, argv);
}
