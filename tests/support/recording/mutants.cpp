#include "tests/support/recording/mutants.hpp"

#include <malloc.h>
#include <spdlog/fmt/fmt.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <fstream>
#include <iterator>
#include <stdexcept>

#include "daemon/commands/replay.hpp"
#include "daemon/commands/run.hpp"
#include "daemon/manual/command.hpp"
#include "daemon/sandbox/confined.hpp"
#include "tests/support/program.hpp"

namespace shaker::test {

namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t processor_s = 10;
constexpr unsigned wall_s = 60;

void put(const fs::path& file, const std::string& bytes) {
    std::ofstream out{file, std::ios::binary};
    if (!out.write(bytes.data(), static_cast<std::streamsize>(bytes.size())).flush())
        throw std::runtime_error{file.string() + " cannot be written"};
}

struct Said {
    sandbox::ChildEnd end;
    std::string words;
};

/// Work in a confined child, with its output.
Said run_quietly(const fs::path& file, const sandbox::Confinement& allowed,
                 const std::function<int()>& work) {
    const int memory = memfd_create("said", MFD_CLOEXEC);
    if (memory < 0) throw std::runtime_error{"no memory for what a child says"};
    sandbox::Confinement with_memory = allowed;
    with_memory.keeps = {memory};
    const auto quiet = [&] {
        dup2(memory, STDOUT_FILENO);
        dup2(memory, STDERR_FILENO);
        mallopt(M_PERTURB, 0x55);  // makes the use of uninitialised memory visible
        alarm(wall_s);
        return work();
    };
    Said said{.end = run_confined(file.string(), with_memory, quiet), .words = {}};
    said.words = file_text(fmt::format("/proc/self/fd/{}", memory));
    close(memory);
    return said;
}

/// Work in a child with all rights; true when it ended with exit status 0.
bool forked(const std::function<int()>& work) {
    const pid_t child = fork();
    if (child == 0) {
        if (std::freopen("/dev/null", "w", stdout) == nullptr) _exit(manual::exit_failure);
        _exit(manual::exit_status_of(work));
    }
    int status = 0;
    return waitpid(child, &status, 0) == child && WIFEXITED(status) && WEXITSTATUS(status) == manual::exit_ok;
}

Said replay_quietly(const fs::path& file) {
    sandbox::Confinement allowed = sandbox::confinement_for(file);
    allowed.processor_s = processor_s;
    return run_quietly(file, allowed, [&] {
        return commands::replay({.file = file, .json = false}) ? manual::exit_ok : manual::exit_not_identical;
    });
}

bool is_clear(const std::string& words) {
    return words.find("shakerd: ") != std::string::npos &&
           words.find("unknown HDF5 error") == std::string::npos;
}

Fate fate_of(const Said& said) {
    const sandbox::ChildEnd& end = said.end;
    if (end.signal == SIGXCPU || end.signal == SIGALRM ||
        (end.signal == SIGKILL && end.processor_s >= static_cast<double>(processor_s)))
        return Fate::timed_out;
    if (end.signal != 0 || said.words.find("Sanitizer") != std::string::npos) return Fate::died;
    if (end.status == manual::exit_ok) return Fate::identical;
    if (end.status == manual::exit_not_identical) return Fate::not_identical;
    return end.status == manual::exit_input && is_clear(said.words) ? Fate::refused : Fate::unclear;
}

std::ptrdiff_t open_files() {
    return std::distance(fs::directory_iterator{"/proc/self/fd"}, fs::directory_iterator{});
}

}  // namespace

const char* name(Fate fate) {
    constexpr const char* names[] = {"identical", "not identical", "refused", "unclear", "died", "timed out"};
    return names[static_cast<int>(fate)];
}

MutantTrials::MutantTrials(const fs::path& folder, bool pictures) : folder_{folder} {
    fs::remove_all(folder_);
    fs::create_directories(folder_);
    std::ofstream{folder_ / "slow.toml"} << "[top]\nframe_rate_hz = 200\n[side]\nframe_rate_hz = 200\n";
    const fs::path file = folder_ / "run.nxs";
    const run::RunOptions options{
        .scene = folder_ / "slow.toml",
        .drive = {},
        .plan = {.periods = 3},
        .out = file,
        .pictures = pictures ? recorded::KeptPictures::region : recorded::KeptPictures::off,
        .identify = false,
        .closed_loop = false};
    // Also in a child, because this process must not start a thread.
    if (!forked([&] {
            commands::run(options);
            return manual::exit_ok;
        }))
        throw std::runtime_error{"recording failed"};
    if (const Said whole = replay_quietly(file); fate_of(whole) != Fate::identical)
        throw std::runtime_error{"the undamaged recording does not replay: " + whole.words};
    for (const auto& entry : fs::recursive_directory_iterator{folder_})
        if (entry.is_regular_file() && file_text(entry.path()).starts_with("\x89HDF"))
            files_.push_back({entry.path(), file_text(entry.path()), structure_of(entry.path())});
    std::ranges::sort(files_, {}, &File::path);
}

MutantTrials::~MutantTrials() {
    std::error_code ignored;
    fs::remove_all(folder_, ignored);
}

Trial MutantTrials::replayed() const {
    const std::ptrdiff_t before = open_files();
    Trial trial;
    try {
        const Said said = replay_quietly(folder_ / "run.nxs");
        trial.fate = fate_of(said);
        trial.said = said.words;
        trial.processor_s = said.end.processor_s;
    } catch (const std::exception& error) {
        trial.parent_harm = error.what();
    }
    if (open_files() != before) trial.parent_harm += "; files are left open";
    if (waitpid(-1, nullptr, WNOHANG) != -1 || errno != ECHILD) trial.parent_harm += "; a child is left";
    return trial;
}

Trial MutantTrials::attempt(std::uint64_t seed, const fs::path& keep) {
    const File& file = files_[seed % files_.size()];
    Mutant mutant = mutant_of(file.bytes, file.structure, seed);
    put(file.path, mutant.bytes);
    Trial trial = replayed();
    for (const File& other : files_)
        if (file_text(other.path) != (&other == &file ? mutant.bytes : other.bytes))
            trial.parent_harm += "; " + other.path.string() + " was changed";
    if (!keep.empty() &&
        (trial.fate == Fate::died || trial.fate == Fate::timed_out || trial.fate == Fate::unclear))
        put(keep / fmt::format("{}-{}", seed, file.path.filename().string()), mutant.bytes);
    put(file.path, file.bytes);
    mutant.bytes.clear();
    trial.mutant = std::move(mutant);
    trial.file = fs::relative(file.path, folder_).string();
    return trial;
}

}  // namespace shaker::test
