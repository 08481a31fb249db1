#pragma once
// Rows of the table of results as JSON (SI units in the keys, null: not known) and as CSV; the lists of
// recordings and campaigns as JSON.
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>

#include "daemon/catalogue/catalogue.hpp"
#include "daemon/catalogue/repeats.hpp"
#include "daemon/catalogue/results_table.hpp"

namespace shaker::catalogue {

/// {"time":...,"asked":{"frequency_hz":...},"v_D_mps":{"value":...,"sigma":...},...}
nlohmann::json json_of(const ResultRow& row);
/// The row in JSON of a process that read a file of unknown origin: wrong types become unknown values, texts
/// become printable and are cut at 500 bytes.
ResultRow row_from(const nlohmann::json& json);
/// Member `key` as a number (otherwise NaN) and as such a text (otherwise empty).
double number_from(const nlohmann::json& json, const char* key);
std::string text_from(const nlohmann::json& json, const char* key);
/// {"value":...,"sigma":...}, with "systematic" where it is known; null for a value that is not known. A
/// number that is not finite becomes null in the text of each JSON value.
nlohmann::json json_of(const calibration::Estimate& estimate, double systematic = NAN);
/// {"frequency_hz":...,"gamma_mps2":...,"rho":...,"phi_rad":...,"overtones":[...]}, or null.
nlohmann::json asked_json(const std::optional<Drive>& drive);
/// {"results":[...]}, each row with its number as "id".
std::string results_json(std::span<const NumberedRow> rows);
/// {"repeats":[{"asked":...,"newest":...,"count":...,"v_D_mps":{...},"D_m":{...},"efficiency":{...},
/// "stated_mps":...,"scatter_mps":...}]}
std::string repeats_json(std::span<const Repeats> all);
/// A heading `name [unit]` per column, then a line per row with 17 significant digits.
std::string results_csv(std::span<const NumberedRow> rows);

/// {"recordings":[{"name":...,"bytes":...,"changed":...,"title":...,"outcome":...,"set_points":[...],...}]}.
/// Members of a recording that was not read yet are null; "trouble" has the reason when it cannot be read.
/// "campaigns" is the list of their folders.
std::string list_json(std::span<const ListedRecording> recordings, std::span<const ListedCampaign> campaigns);

}  // namespace shaker::catalogue
