#pragma once
// shakerd recover: completes a recording whose writer ended without closing it.
#include <filesystem>

namespace shaker::commands {

struct RecoverOptions {
    std::filesystem::path file;  // the recording or its .part
    bool json = false;
};
/// Paths of a recording that may lack its end.
struct RecoveredFiles {
    std::filesystem::path file, part, journal;
    std::filesystem::path working;  // the new file until it is complete
};
RecoveredFiles recovered_files(const RecoverOptions& options);

/// Completes a recording after a crash: writes a new file with all intact data, `working`. A finished
/// recording is only verified by its checksums; false when it was changed.
bool recover(const RecoverOptions& options);
/// Gives the new file the recording's name. Throws DeviceError.
void name_recovered(const RecoveredFiles& files);

}  // namespace shaker::commands
