#include "tests/orders/campaign.hpp"

#include <fcntl.h>
#include <spdlog/fmt/fmt.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <stdexcept>

#include "tests/orders/simulation.hpp"

namespace shaker::orders {

namespace {

using nlohmann::json;
using Clock = std::chrono::steady_clock;

// Most memory of a process that plays one seed, bytes: twice that of a daemon at rest with its queues.
constexpr double memory_bound = 120e6;

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

double most_bytes() {
    rusage usage{};
    ::getrusage(RUSAGE_SELF, &usage);
    return 1024.0 * static_cast<double>(usage.ru_maxrss);
}

void play_seed(const Campaign& campaign, std::uint64_t seed, const std::filesystem::path& lines) {
    const std::filesystem::path folder = campaign.folder / fmt::format("seed-{}", seed);
    const Outcome o = simulate(plan_of(seed), folder);
    std::filesystem::remove_all(folder);
    json broken = json::array();
    if (!SHAKER_SANITIZED && most_bytes() > memory_bound)  // a sanitiser keeps what was freed
        broken.push_back(fmt::format("memory is bounded: {:.0f} MB", most_bytes() / 1e6));
    for (const Violation& v : o.violations)
        broken.push_back(fmt::format("{}: at {:.4f} s {}", v.law, v.at_s, v.words));
    append(!campaign.done.empty() && broken.empty() ? campaign.done : lines,
           {{"seed", seed},
            {"virtual_s", o.virtual_s},
            {"aborts", o.aborts},
            {"trips", o.trips},
            {"recordings", o.recordings},
            {"recovered", o.recovered},
            {"slowest_abort_s", o.slowest_abort_s},
            {"broken", broken},
            {"coverage", o.coverage.numbers()},
            {"bytes", most_bytes()}});
}

// Every jobs-th seed, each in a process of its own: no seed depends on another.
void work(const Campaign& campaign, int job, const std::filesystem::path& lines) {
    const std::set<std::uint64_t> done = done_in(campaign.done);
    const auto end = Clock::now() + std::chrono::duration_cast<Clock::duration>(
                                        std::chrono::duration<double>{campaign.most_s});
    for (std::uint64_t i = 0; campaign.most_s > 0 ? Clock::now() < end : i < campaign.seeds; ++i) {
        const std::uint64_t seed = campaign.first + i;
        if (i % static_cast<std::uint64_t>(campaign.jobs) != static_cast<std::uint64_t>(job)) continue;
        if (done.contains(seed)) continue;
        if (const pid_t child = ::fork(); child == 0) {
            play_seed(campaign, seed, lines);
            ::_exit(0);
        } else {
            int status = 0;
            ::waitpid(child, &status, 0);
            if (status != 0) append(lines, {{"seed", seed}, {"died", status}});
        }
    }
}

void add(Totals& totals, const json& o) {
    ++totals.seeds;
    if (o.contains("died")) {
        totals.broken.emplace_back(o["seed"].get<std::uint64_t>(),
                                   fmt::format("the daemon died with status {}", o["died"].get<int>()));
        return;
    }
    totals.virtual_s += o["virtual_s"].get<double>();
    totals.aborts += o["aborts"].get<std::uint64_t>();
    totals.trips += o["trips"].get<std::uint64_t>();
    totals.recordings += o["recordings"].get<std::uint64_t>();
    totals.recovered += o["recovered"].get<std::uint64_t>();
    totals.slowest_abort_s = std::max(totals.slowest_abort_s, o["slowest_abort_s"].get<double>());
    totals.most_bytes = std::max(totals.most_bytes, o["bytes"].get<double>());
    if (!o["broken"].empty())
        totals.broken.emplace_back(o["seed"].get<std::uint64_t>(), o["broken"].front().get<std::string>());
    totals.coverage.add(o["coverage"].get<std::vector<std::uint64_t>>());
}

}  // namespace

Totals play(const Campaign& campaign) {
    const auto began = Clock::now();
    std::filesystem::create_directories(campaign.folder);
    double before_s = 0;
    read_lines(campaign.done, [&](const json& one) { before_s += one["virtual_s"].get<double>(); });
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
