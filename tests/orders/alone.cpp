#include "tests/orders/alone.hpp"

#include <spdlog/fmt/fmt.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <nlohmann/json.hpp>
#include <stdexcept>

namespace shaker::orders {

namespace {

using nlohmann::json;

// Most memory of a process that plays one plan, bytes: twice that of a daemon at rest with its queues.
// With the eightfold samples and the tenfold frames of a drive at 1000 Hz its queues are larger.
constexpr double memory_bound = 120e6, memory_bound_fast = 200e6;
constexpr const char* stays_up = "the daemon stays up";

double most_bytes() {
    rusage usage{};
    ::getrusage(RUSAGE_SELF, &usage);
    return 1024.0 * static_cast<double>(usage.ru_maxrss);
}

Outcome played(const Plan& plan, const std::filesystem::path& folder) try {
    Outcome o = simulate(plan, folder);
    o.most_bytes = most_bytes();
    if (!SHAKER_SANITIZED && o.most_bytes > (fast(plan) ? memory_bound_fast : memory_bound))
        o.violations.push_back(
            {"memory is bounded", o.virtual_s, fmt::format("{:.0f} MB", o.most_bytes / 1e6)});
    return o;
} catch (const std::exception& e) {
    Outcome o;
    o.violations.push_back({stays_up, 0, e.what()});
    return o;
}

void write_all(int descriptor, const std::string& text) {
    for (std::size_t done = 0; done < text.size();) {
        const ssize_t written = ::write(descriptor, text.data() + done, text.size() - done);
        if (written <= 0) return;
        done += static_cast<std::size_t>(written);
    }
}

std::string read_all(int descriptor) {
    std::string all;
    std::array<char, 4096> part{};
    for (ssize_t got = 0; (got = ::read(descriptor, part.data(), part.size())) > 0;)
        all.append(part.data(), static_cast<std::size_t>(got));
    return all;
}

std::string words_of(int status) {
    if (WIFSIGNALED(status))
        return fmt::format("signal {} ({}) ended it", WTERMSIG(status), ::strsignal(WTERMSIG(status)));
    return fmt::format("it ended with status {}", WEXITSTATUS(status));
}

Plan without(const Plan& plan, std::size_t from, std::size_t to) {
    Plan less = plan;
    const auto cut = [&](auto& list, std::size_t before) {
        const auto at = [&](std::size_t i) {
            return list.begin() +
                   static_cast<std::ptrdiff_t>(std::min(list.size(), std::max(i, before) - before));
        };
        list.erase(at(from), at(to));
    };
    cut(less.faults, plan.moves.size());
    cut(less.moves, 0);
    return less;
}

}  // namespace

json as_json(const Outcome& o) {
    json broken = json::array();
    for (const Violation& v : o.violations) broken.push_back({v.law, v.at_s, v.words});
    return {{"virtual_s", o.virtual_s},
            {"fingerprint", o.fingerprint},
            {"aborts", o.aborts},
            {"trips", o.trips},
            {"recordings", o.recordings},
            {"recovered", o.recovered},
            {"slowest_abort_s", o.slowest_abort_s},
            {"broken", broken},
            {"coverage", o.coverage.numbers()},
            {"bytes", o.most_bytes},
            {"log", o.log}};
}

Outcome outcome_of(const json& j) {
    Outcome o;
    for (const json& v : j.at("broken")) o.violations.push_back({v.at(0), v.at(1), v.at(2)});
    j.at("virtual_s").get_to(o.virtual_s);
    j.at("aborts").get_to(o.aborts);
    j.at("trips").get_to(o.trips);
    j.at("recordings").get_to(o.recordings);
    j.at("recovered").get_to(o.recovered);
    j.at("slowest_abort_s").get_to(o.slowest_abort_s);
    j.at("bytes").get_to(o.most_bytes);
    o.coverage.add(j.at("coverage").get<std::vector<std::uint64_t>>());
    o.fingerprint = j.value("fingerprint", o.fingerprint);  // files of campaigns have neither
    o.log = j.value("log", o.log);
    return o;
}

Outcome play_alone(const Plan& plan, const std::filesystem::path& folder) {
    std::array<int, 2> ends{};
    if (::pipe(ends.data()) != 0) throw std::runtime_error{fmt::format("pipe: {}", std::strerror(errno))};
    std::fflush(nullptr);  // otherwise the child prints it again
    const pid_t child = ::fork();
    if (child < 0) throw std::runtime_error{fmt::format("fork: {}", std::strerror(errno))};
    if (child == 0) {
        ::close(ends[0]);
        write_all(ends[1],
                  as_json(played(plan, folder)).dump(-1, ' ', false, json::error_handler_t::replace));
        ::_exit(0);
    }
    ::close(ends[1]);
    const json result = json::parse(read_all(ends[0]), nullptr, false);
    ::close(ends[0]);
    int status = 0;
    while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {
    }
    std::filesystem::remove_all(folder);
    if (status == 0 && result.is_object()) return outcome_of(result);
    Outcome died;
    died.violations.push_back({stays_up, 0, words_of(status)});
    return died;
}

Shortest shortest(const Plan& plan, const Outcome& outcome, const std::filesystem::path& folder) {
    Shortest best{plan, outcome};
    if (outcome.violations.empty()) return best;
    int tried = 0;
    const auto shortens = [&](const Plan& less) {
        const Outcome now = play_alone(less, folder / fmt::format("try-{}", ++tried));
        if (now.violations.empty() || now.violations.front().law != outcome.violations.front().law)
            return false;
        best = {less, now};
        return true;
    };
    for (std::size_t part = std::max<std::size_t>(1, plan.size() / 2);;
         part = std::max<std::size_t>(1, part / 2)) {
        bool shorter = false;
        for (std::size_t from = 0; from < best.plan.size();) {
            const std::size_t to = std::min(best.plan.size(), from + part);
            if (shortens(without(best.plan, from, to)))
                shorter = true;
            else
                from = to;
        }
        if (part == 1 && !shorter) break;
    }
    double end_s = best.outcome.violations.front().at_s;  // 0 for a crash
    for (const Move& m : best.plan.moves) end_s = std::max(end_s, m.at_s);
    for (const Fault& f : best.plan.faults) end_s = std::max(end_s, f.at_s);
    Plan early = best.plan;
    early.length_s = std::ceil(end_s + 0.5);
    if (early.length_s < best.plan.length_s) shortens(early);
    return best;
}

}  // namespace shaker::orders
