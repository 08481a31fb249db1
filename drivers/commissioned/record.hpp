#pragma once
// The record of a bench's commissioning: a file beside its rig file, valid while that file and the files that
// it names are unchanged.
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace shaker::commissioned {

/// One test and its result as text.
struct Item {
    std::string name, result;
};

/// A file that the rig file names, as the bench was opened with it, or the mixer of a sound card.
struct Named {
    std::string what;  // "calibration of accelerometer", "calibration of camera top", "alsa_config",
                       // "mixer of hw:CARD=M4"
    std::string text;  // its content; of a mixer MixerDevice::read
    bool operator==(const Named&) const = default;
};

struct Record {
    std::string date{};          // ISO 8601
    std::string rig_sha256{};    // of the rig file
    std::vector<Named> files{};  // that it names
    std::vector<Item> items{};
};

/// Record::rig_sha256 of this content of a rig file.
std::string rig_hash(const std::string& rig_text);

/// "bench.toml" has its record in "bench.toml.commissioned".
std::filesystem::path record_of(const std::filesystem::path& rig);

/// Writes the record of this rig file, as TOML. DeviceError when it cannot be written.
void write_record(const std::filesystem::path& rig, const Record& record);
/// The record of this rig file; empty when none exists. InputError for a file that is not a record.
std::optional<Record> read_record(const std::filesystem::path& rig);

inline constexpr const char* mixer_of = "mixer of ";  // begins Named::what

/// Controls of mixers that are not as they were.
struct MixerChange {
    std::string why{};  // with the controls and the remedy; empty: none
    int controls = 0;
};
/// Compares the mixers that both lists have; other files do not count. `then`: of a record or of the opening.
MixerChange mixers_changed(const std::vector<Named>& then, const std::vector<Named>& now);

/// The reason why a bench with this content of the rig file and of the files that it names counts as not
/// commissioned, with the remedy; empty: its record is valid.
std::string missing_record(const std::filesystem::path& rig, const std::string& rig_text,
                           const std::vector<Named>& files);

}  // namespace shaker::commissioned
