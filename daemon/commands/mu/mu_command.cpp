#include "daemon/commands/mu/mu_command.hpp"

#include <spdlog/fmt/fmt.h>

#include "daemon/campaign/campaign_folder.hpp"
#include "daemon/campaign/law_points.hpp"
#include "daemon/report/printing.hpp"
#include "drivers/errors.hpp"

namespace shaker::commands {

std::filesystem::path points_file(const std::filesystem::path& campaign) {
    const bool folder = std::filesystem::is_directory(campaign);
    std::filesystem::path file = folder ? campaign / campaign::table_name : campaign;
    if (std::filesystem::exists(file)) return file;
    if (folder)
        throw InputError{fmt::format(
            "{}: the folder has no {}; \"shakerd campaign {} --reduce\" makes one from the recordings",
            campaign.string(), campaign::table_name, campaign.string())};
    throw InputError{fmt::format("{}: no such file or folder", campaign.string())};
}

std::string mu_text(const MuOptions& options) {
    std::vector<law::Point> points;
    for (std::size_t i = 0; i < options.campaigns.size(); ++i) {
        const std::filesystem::path file = points_file(options.campaigns[i]);
        if (!campaign::has_points(file))
            throw InputError{
                fmt::format("{}: expected the folder of a campaign or its points table campaign.nxs",
                            options.campaigns[i].string())};
        std::vector<law::Point> own = campaign::law_points(campaign::read_points(file), static_cast<int>(i));
        if (own.empty())
            throw InputError{
                fmt::format("{}: the campaign has no measured point", options.campaigns[i].string())};
        points.insert(points.end(), std::make_move_iterator(own.begin()), std::make_move_iterator(own.end()));
    }
    const law::Findings findings = law::analyse(std::move(points), options.law, options.errors);
    return options.json ? findings_json(findings) : findings_text(findings);
}

void print_mu(const MuOptions& options) { report::say(mu_text(options)); }

}  // namespace shaker::commands
