#pragma once
// shakerd recover: completes a recording whose writer ended without closing it.
#include <filesystem>

namespace shaker::commands {

struct RecoverOptions {
    std::filesystem::path file;       // the recording or its .part
    std::filesystem::path working{};  // the new file, in a folder that nobody else writes
    bool json = false;
};
/// Paths of a recording that may lack its end.
struct RecoveredFiles {
    std::filesystem::path file, part, journal;
};
RecoveredFiles recovered_files(const RecoverOptions& options);

/// Completes a recording after a crash: writes a new file with all intact data, `working`. A finished
/// recording is only verified by its checksums; false when it was changed.
bool recover(const RecoverOptions& options);
/// The same in a confined child; the recovered file gets its name. Exit status of the child.
int recover_confined(RecoverOptions options);

}  // namespace shaker::commands
