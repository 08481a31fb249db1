#include "tests/orders/campaign.hpp"

#include <fcntl.h>
#include <spdlog/fmt/fmt.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <stdexcept>

#include "tests/orders/alone.hpp"
#include "tests/orders/plan_text.hpp"

namespace shaker::orders {

namespace {

using nlohmann::json;
using Clock = std::chrono::steady_clock;

// One line of JSON for each seed. A last line that a power cut has torn does not count.
template <class Use>
void read_lines(const std::filesystem::path& file, const Use& use) {
    std::ifstream in{file};
    for (std::string line; std::getline(in, line);)
        if (const json one = json::parse(line, nullptr, false); one.is_object()) use(one);
}

std::set<std::uint64_t> done_in(const std::filesystem::path& file) {
    std::set<std::uint64_t> done;
    read_lines(file, [&](const json& one) { done.insert(one["seed"].get<std::uint64_t>()); });
    return done;
}

// Jobs append to the same file: a line is written by one call.
void append(const std::filesystem::path& file, const json& line) {
    const std::string text = line.dump() + '\n';
    const int descriptor = ::open(file.c_str(), O_WRONLY | O_APPEND | O_CREAT | O_CLOEXEC, 0644);
    const ssize_t written = ::write(descriptor, text.data(), text.size());
    ::close(descriptor);
    if (written != std::ssize(text)) throw std::runtime_error{fmt::format("{}: not written", file.string())};
}

void play_seed(const Campaign& campaign, std::uint64_t seed, const std::filesystem::path& lines) {
    const std::filesystem::path folder = campaign.folder / fmt::format("seed-{}", seed);
    const Plan plan = plan_of(seed);
    const Outcome outcome = play_alone(plan, folder);
    json line = as_json(outcome);
    line["seed"] = seed;
    line.erase("log");
    const bool broken = !outcome.violations.empty();
    append(!campaign.done.empty() && !broken ? campaign.done : lines, line);
    if (!broken || campaign.plans.empty()) return;
    const Shortest least = shortest(plan, outcome, folder);
    write_plan(plan_file(campaign.plans, seed), least.plan, least.outcome.violations.front());
}

// Every jobs-th seed.
void work(const Campaign& campaign, int job, const std::filesystem::path& lines) {
    const std::set<std::uint64_t> done = done_in(campaign.done);
    for (std::uint64_t i = 0; i < campaign.seeds; ++i) {
        const std::uint64_t seed = campaign.first + i;
        if (i % static_cast<std::uint64_t>(campaign.jobs) != static_cast<std::uint64_t>(job)) continue;
        if (!done.contains(seed)) play_seed(campaign, seed, lines);
    }
}

void add(Totals& totals, const json& line) {
    const Outcome o = outcome_of(line);
    ++totals.seeds;
    totals.virtual_s += o.virtual_s;
    totals.aborts += o.aborts;
    totals.trips += o.trips;
    totals.recordings += o.recordings;
    totals.recovered += o.recovered;
    totals.slowest_abort_s = std::max(totals.slowest_abort_s, o.slowest_abort_s);
    totals.most_bytes = std::max(totals.most_bytes, o.most_bytes);
    if (!o.violations.empty())
        totals.broken.emplace_back(line["seed"].get<std::uint64_t>(), text(o.violations.front()));
    totals.coverage.add(o.coverage);
}

}  // namespace

std::filesystem::path plan_file(const std::filesystem::path& plans, std::uint64_t seed) {
    return plans / fmt::format("seed_{}.plan", seed);
}

Totals play(const Campaign& campaign) {
    const auto began = Clock::now();
    std::filesystem::create_directories(campaign.folder);
    double before_s = 0;
    read_lines(campaign.done, [&](const json& one) { before_s += outcome_of(one).virtual_s; });
    std::vector<std::pair<pid_t, std::filesystem::path>> jobs;
    for (int job = 0; job < campaign.jobs; ++job) {
        const std::filesystem::path lines = campaign.folder / fmt::format("job-{}.json", job);
        const pid_t child = ::fork();
        if (child == 0) {
            int status = 0;
            try {
                work(campaign, job, lines);
            } catch (const std::exception& e) {
                fmt::print(stderr, "{}\n", e.what());
                status = 1;
            }
            ::_exit(status);
        }
        jobs.emplace_back(child, lines);
    }
    Totals totals;
    const auto add_all = [&](const std::filesystem::path& file) {
        read_lines(file, [&](const json& one) { add(totals, one); });
    };
    for (const auto& [child, lines] : jobs) {
        int status = 0;
        ::waitpid(child, &status, 0);
        add_all(lines);
        if (status != 0) totals.broken.emplace_back(0, fmt::format("a job ended with status {}", status));
    }
    add_all(campaign.done);
    totals.played_s = totals.virtual_s - before_s;
    totals.wall_s = std::chrono::duration<double>(Clock::now() - began).count();
    return totals;
}

}  // namespace shaker::orders
