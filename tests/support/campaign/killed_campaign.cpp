#include "tests/support/campaign/killed_campaign.hpp"

#include <spdlog/fmt/fmt.h>

#include <chrono>
#include <cmath>
#include <csignal>
#include <set>
#include <stdexcept>
#include <thread>

#include "daemon/campaign/campaign_folder.hpp"
#include "tests/support/environment.hpp"
#include "tests/support/paths.hpp"
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

// The program that starts while this exists logs its calls, and dies after `last` of them (0: does not).
Environment calls_of(const std::filesystem::path& folder, const std::filesystem::path& log,
                     std::size_t last = 0) {
    return Environment{{{"LD_PRELOAD", build_dir() + "/preload_disk_log.so"},
                        {"SHAKER_DISK_FOLDER", folder.string()},
                        {"SHAKER_DISK_LOG", log.string()},
                        {"SHAKER_DISK_KILL", std::to_string(last)}}};
}

}  // namespace

KilledCampaigns::KilledCampaigns(std::filesystem::path plan, std::filesystem::path folder, Whole whole)
    : plan_{std::move(plan)}, folder_{std::move(folder)} {
    std::filesystem::create_directories(folder_);
    folder_ = std::filesystem::canonical(folder_);
    const std::string command = fmt::format("campaign {} -o whole", plan_.string());
    const auto began = std::chrono::steady_clock::now();
    Outcome outcome;
    if (whole == Whole::logged) {
        const Environment logged = calls_of(folder_ / "whole", folder_ / "log");
        outcome = shakerd(command, folder_);
    } else {
        outcome = shakerd(command, folder_);
    }
    lasts_s_ = std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
    if (outcome.status != 0) throw std::runtime_error{outcome.out + outcome.err};
    if (whole == Whole::logged) images_ = std::make_unique<DiskImages>(folder_ / "log", folder_ / "whole");
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
    go_on(name, 0, result);
    return result;
}

Killed KilledCampaigns::kill_at(std::size_t call, std::size_t again) const {
    Killed result{.killed = call < images_->size()};
    go_on(image(call).filename().string(), again, result);
    return result;
}

std::filesystem::path KilledCampaigns::image(std::size_t call) const {
    std::filesystem::path folder = folder_ / "image";
    std::filesystem::remove_all(folder);
    std::filesystem::create_directories(folder);
    images_->build(folder, call, Surviving::all, 0);
    return folder;
}

std::vector<std::string> KilledCampaigns::recover_at(std::size_t call) const {
    const std::filesystem::path folder = image(call);
    std::vector<std::string> findings, parts;
    for (const auto& entry : std::filesystem::directory_iterator{folder})
        if (entry.path().string().ends_with(".nxs.part")) parts.push_back(entry.path().filename().string());
    for (const std::string& part : parts) {
        const std::vector<std::size_t> syncs = images_->syncs(part);
        const bool synced = !syncs.empty() && syncs.front() <= call;
        for (const char* time : {"once", "again"}) {
            const Outcome outcome = shakerd("recover " + part, folder);
            const auto refused = [&](const char* words) {
                return outcome.status == 2 && outcome.err.find(words) != std::string::npos;
            };
            const bool nothing = !synced && refused("nothing can be recovered");
            const bool table = part.starts_with(campaign::table_name) && refused("--continue");
            if (outcome.status != 0 && !nothing && !table)
                findings.push_back(fmt::format("{} recovered {}: status {}: {}{}", part, time, outcome.status,
                                               outcome.out, outcome.err));
        }
    }
    return findings;
}

void KilledCampaigns::go_on(const std::string& name, std::size_t again, Killed& result) const {
    const std::filesystem::path folder = folder_ / name;
    if (!std::filesystem::exists(folder / campaign::journal_name)) return;  // it had hardly begun
    std::set<int> before = ended_in(folder);
    result.ended_before = static_cast<int>(before.size());
    if (!result.killed) return;
    const std::string command = fmt::format("campaign {} --continue", name);
    if (again > 0) {
        const Environment killed = calls_of(folder, folder_ / "log-again", again);
        result.killed_again = shakerd(command, folder_).status == 128 + SIGKILL;
        before.merge(ended_in(folder));
    }
    const Outcome outcome = shakerd(command, folder_);
    if (outcome.status != 0) {
        result.findings.push_back(fmt::format("status {}: {}{}", outcome.status, outcome.out, outcome.err));
        return;
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
}

}  // namespace shaker::test
