#pragma once
// shakerd recover: completes a recording whose writer ended without closing it.
#include <filesystem>

namespace shaker::commands {

struct RecoverOptions {
    std::filesystem::path file;  // the recording or its .part
    bool json = false;
};
/// Completes a recording after a crash: writes a new file with all intact data under the recording's name. A
/// finished recording is only verified by its checksums; false when it was changed.
bool recover(const RecoverOptions& options);

}  // namespace shaker::commands
