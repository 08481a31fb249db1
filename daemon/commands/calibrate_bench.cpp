#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cstdio>
#include <iterator>

#include "daemon/campaign/campaign_folder.hpp"
#include "daemon/commands/calibrate/calibrate.hpp"
#include "daemon/commands/campaign.hpp"
#include "daemon/commands/table.hpp"
#include "drivers/errors.hpp"

namespace shaker::commands {

namespace {

/// Where the drives of "calibrate response" are recorded: beside the file. InputError where something is
/// there.
std::filesystem::path response_folder(const std::filesystem::path& file) {
    if (!file.has_filename()) throw InputError{fmt::format("--output {}: has no file name", file.string())};
    std::filesystem::path folder = std::filesystem::path{file}.replace_extension();
    if (folder == file) folder += "-drives";
    if (std::filesystem::exists(folder) && !std::filesystem::is_empty(folder))
        throw InputError{
            fmt::format("{0}: is there already; give another --output, or fit its recordings: "
                        "\"shakerd calibrate response --from {0} -o {1}\"",
                        folder.string(), file.string())};
    return folder;
}

/// "calibrate response" without recordings drives its plan into a folder beside the file first.
int act_on_calibrate(const manual::Values& values) {
    if (values.text("DEVICE") != "response" || values.has("--from") || values.has("--coupled-dc"))
        return calibrate(values);
    refuse_others("response", values, {"DEVICE", "--rig", "--scene", "--output", "--json"});
    constexpr const char* built_in = "built-in plan response.toml";
    const std::filesystem::path file = response_file(values);
    CampaignOptions options{
        .plan = built_in, .plan_text = response_plan, .folder = response_folder(file), .run = {}};
    options.run.rig = values.text("--rig");
    options.run.scene = values.text("--scene");
    options.run.standard = simulated::paper_scene(simulated::Detail::positions);
    options.run.pictures = recorded::KeptPictures::off;
    if (values.has("--json")) options.lines_to = stderr;
    const std::string then =
        fmt::format("\"shakerd calibrate response --from {} -o {}\"", options.folder.string(), file.string());
    try {
        measure_campaign(options);
    } catch (const TripError& e) {
        throw TripError{fmt::format("{}, and {}", e.what(), then)};
    }
    const auto points = campaign::read_campaign(options.folder).progress.points;
    const auto measured = std::ranges::count_if(points, [](const auto& point) {
        return point.second.ended && point.second.ended->outcome == campaign::Outcome::measured;
    });
    const auto asked =
        std::ssize(campaign::schedule(campaign::parse_plan(std::string{response_plan}, built_in)));
    if (measured < asked)
        throw InputError{fmt::format(
            "{} of {} drives were measured; nothing is fitted. \"{}\" goes on, {} fits what there is",
            measured, asked, go_on(options), then)};
    calibrate_response(values, file, {options.folder});
    return manual::exit_ok;
}

}  // namespace

manual::Command calibrate_row() {
    manual::Command row = calibrations_row();
    row.act = act_on_calibrate;
    return row;
}

}  // namespace shaker::commands
