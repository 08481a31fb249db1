#pragma once
// The lists of recordings and campaigns as JSON.
#include <span>
#include <string>

#include "daemon/catalogue/catalogue.hpp"

namespace shaker::catalogue {

/// {"recordings":[{"name":...,"bytes":...,"changed":...,"title":...,"outcome":...,"set_points":[...],...}]}.
/// Members of a recording that was not read yet are null; "trouble" has the reason when it cannot be read.
/// "campaigns" is the list of their folders.
std::string list_json(std::span<const ListedRecording> recordings, std::span<const ListedCampaign> campaigns);

}  // namespace shaker::catalogue
