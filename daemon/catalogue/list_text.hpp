#pragma once
// The list of recordings as JSON.
#include <span>
#include <string>

#include "daemon/catalogue/catalogue.hpp"

namespace shaker::catalogue {

/// {"recordings":[{"name":...,"bytes":...,"changed":...,"title":...,"outcome":...,"set_points":[...],...}]}.
/// Members of a recording that was not read yet are null; "trouble" has the reason when it cannot be read.
std::string list_json(std::span<const ListedRecording> recordings);

}  // namespace shaker::catalogue
