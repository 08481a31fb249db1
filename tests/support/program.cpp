#include "tests/support/program.hpp"

#include <gtest/gtest.h>
#include <spawn.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <fstream>
#include <sstream>
#include <thread>

#include "tests/support/paths.hpp"

namespace shaker::test {

namespace {

// In memory where the system has such a folder: a program that is timed does not wait for a busy disk.
std::filesystem::path temporary() {
    const std::filesystem::path memory = "/dev/shm";
    const bool there = ::access(memory.c_str(), W_OK) == 0;
    std::string name =
        ((there ? memory : std::filesystem::temp_directory_path()) / "shakerd-test-XXXXXX").string();
    ::close(::mkstemp(name.data()));
    return name;
}

double seconds_of(const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
}

}  // namespace

std::string file_text(const std::filesystem::path& file) {
    std::ifstream in{file, std::ios::binary};
    std::ostringstream text;
    text << in.rdbuf();
    return text.str();
}

Program::Program(const std::string& name, const std::string& arguments, const std::filesystem::path& folder,
                 const std::string& input)
    : in_{temporary()}, out_{temporary()}, err_{temporary()} {
    std::ofstream{in_} << input;
    std::string command = "cd '" + folder.string() + "' && exec '" + test::build_dir() + "/" + name + "' " +
                          arguments + " >'" + out_.string() + "' 2>'" + err_.string() + "' <'" +
                          in_.string() + "'";
    std::string shell = "/bin/sh", option = "-c";
    char* const words[] = {shell.data(), option.data(), command.data(), nullptr};
    if (posix_spawn(&pid_, shell.c_str(), nullptr, nullptr, words, environ) != 0)
        throw std::runtime_error{"no shell"};
}

Program::~Program() {
    if (!outcome_) wait(0);
    for (const auto& file : {in_, out_, err_}) std::filesystem::remove(file);
}

bool Program::collect(int options) {
    if (outcome_) return true;
    int status = 0;
    rusage usage{};
    if (wait4(pid_, &status, options, &usage) != pid_) return false;
    outcome_ = Outcome{WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status), file_text(out_),
                       file_text(err_), seconds_of(usage.ru_utime) + seconds_of(usage.ru_stime)};
    return true;
}

bool Program::ended() { return collect(WNOHANG); }

bool Program::waits_for_content(const std::filesystem::path& file) {
    std::error_code ignored;
    while (!ended()) {
        if (std::filesystem::file_size(file, ignored) > 0 && !ignored) return true;
        std::this_thread::sleep_for(std::chrono::milliseconds{1});
    }
    return false;
}

Outcome Program::wait(double limit_s) {
    using Clock = std::chrono::steady_clock;
    const auto until = Clock::now() + std::chrono::duration<double>{limit_s};
    while (!ended() && Clock::now() < until) std::this_thread::sleep_for(std::chrono::milliseconds{2});
    if (!outcome_) {
        ::kill(pid_, SIGKILL);
        collect(0);
    }
    return *outcome_;
}

Outcome shakerd(const std::string& arguments, const std::filesystem::path& folder) {
    return Program{"shakerd", arguments, folder}.wait();
}

std::filesystem::path fresh_folder() {
    const auto* info = testing::UnitTest::GetInstance()->current_test_info();
    auto folder = std::filesystem::path{testing::TempDir()} /
                  (std::string{"shakerd-"} + info->test_suite_name() + "-" + info->name());
    std::filesystem::remove_all(folder);
    std::filesystem::create_directories(folder);
    return folder;
}

}  // namespace shaker::test
