#include "tests/support/campaign/killed_campaign.hpp"

#include <spdlog/fmt/fmt.h>

#include <chrono>
#include <cmath>
#include <csignal>
#include <set>
#include <stdexcept>
#include <thread>

#include "daemon/campaign/campaign_folder.hpp"
#include "tests/support/program.hpp"

namespace shaker::test {

namespace {

constexpr double most_errors = 5;  // by which two measurements of a point may differ

std::set<int> ended_in(const std::filesystem::path& folder) {
    std::set<int> ended;
    for (const auto& [number, point] : campaign::read_campaign(folder).progress.points)
        if (point.ended) ended.insert(number);
    return ended;
}

void compare(const campaign::PointRow& was, const campaign::PointRow& is, bool ended_before,
             std::vector<std::string>& findings) {
    if (is.outcome != was.outcome)
        findings.push_back(
            fmt::format("point {}: {} ({}), was {}", is.point, is.outcome, is.reason, was.outcome));
    else if (ended_before && is.v_D.value != was.v_D.value)
        findings.push_back(fmt::format("point {}: v_D {} was {}", is.point, is.v_D.value, was.v_D.value));
    const double allowed = most_errors * std::hypot(is.v_D.sigma, was.v_D.sigma);
    if (std::abs(is.v_D.value - is.true_v_D - was.v_D.value + was.true_v_D) > allowed)
        findings.push_back(fmt::format("point {}: v_D {} was {}", is.point, is.v_D.value, was.v_D.value));
}

}  // namespace

KilledCampaigns::KilledCampaigns(std::filesystem::path plan, std::filesystem::path folder)
    : plan_{std::move(plan)}, folder_{std::move(folder)} {
    std::filesystem::create_directories(folder_);
    const auto began = std::chrono::steady_clock::now();
    const Outcome outcome = shakerd(fmt::format("campaign {} -o whole", plan_.string()), folder_);
    lasts_s_ = std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
    if (outcome.status != 0) throw std::runtime_error{outcome.out + outcome.err};
    whole_ = campaign::read_points(folder_ / "whole" / campaign::table_name);
}

Killed KilledCampaigns::kill(double after_s, int number) const {
    const std::string name = fmt::format("killed-{}", number);
    Killed result;
    {
        Program program{"shakerd", fmt::format("campaign {} -o {}", plan_.string(), name), folder_};
        std::this_thread::sleep_for(std::chrono::duration<double>{after_s});
        ::kill(program.pid(), SIGKILL);
        result.killed = program.wait().status == 128 + SIGKILL;
    }
    const std::filesystem::path folder = folder_ / name;
    if (!std::filesystem::exists(folder / campaign::journal_name)) return result;  // it had hardly begun
    std::set<int> before = ended_in(folder);
    result.ended_before = static_cast<int>(before.size());
    if (!result.killed) return result;
    const Outcome outcome = shakerd(fmt::format("campaign {} --continue", name), folder_);
    if (outcome.status != 0) {
        result.findings.push_back(fmt::format("status {}: {}{}", outcome.status, outcome.out, outcome.err));
        return result;
    }
    // The recording may lack the measurement of the last half second although the journal has it. Then the
    // pass is lost by name, and its point is measured again.
    for (const campaign::JournalEntry& entry : campaign::read_campaign(folder).entries)
        if (const auto* lost = std::get_if<campaign::PassLost>(&entry.what)) before.erase(lost->point);
    const campaign::PointsTable is = campaign::read_points(folder / campaign::table_name);
    for (std::size_t i = 0; i < whole_.points.size(); ++i)
        compare(whole_.points[i], is.points.at(i), before.contains(whole_.points[i].point), result.findings);
    std::set<std::pair<std::string, int>> counted;
    for (const campaign::PointPass& pass : is.passes)
        if (pass.measurement > 0 && !counted.emplace(pass.recording, pass.measurement).second)
            result.findings.push_back(
                fmt::format("measurement {} of {} counts twice", pass.measurement, pass.recording));
    return result;
}

}  // namespace shaker::test
