#pragma once
// Runs the built programs.
#include <sys/types.h>

#include <filesystem>
#include <optional>
#include <string>

namespace shaker::test {

struct Outcome {
    int status = -1;   // exit status; 128 + n when a signal n ended it
    std::string out;   // standard output
    std::string err;   // standard error
    double cpu_s = 0;  // processor time used
};

/// A built program that runs beside the test. The destructor kills it if it still runs.
class Program {
public:
    /// `name` with these arguments, as a shell would split them, in `folder`; `input` is its standard input.
    Program(const std::string& name, const std::string& arguments, const std::filesystem::path& folder,
            const std::string& input = {});
    ~Program();
    Program(const Program&) = delete;
    Program& operator=(const Program&) = delete;

    [[nodiscard]] pid_t pid() const noexcept { return pid_; }
    /// The file with its standard output.
    [[nodiscard]] const std::filesystem::path& printed() const noexcept { return out_; }
    /// The file with its standard error.
    [[nodiscard]] const std::filesystem::path& said() const noexcept { return err_; }
    [[nodiscard]] bool ended();
    /// Waits until `file` has content; false when the program ended before.
    bool waits_for_content(const std::filesystem::path& file);
    /// Waits for its end; kills it after `limit_s`.
    Outcome wait(double limit_s = 600);

private:
    bool collect(int options);

    std::filesystem::path in_, out_, err_;
    pid_t pid_ = -1;
    std::optional<Outcome> outcome_;
};

/// All bytes of a file; empty when it cannot be read.
std::string file_text(const std::filesystem::path& file);

/// Runs shakerd with these arguments in `folder` and waits for its end.
Outcome shakerd(const std::string& arguments, const std::filesystem::path& folder);

/// A new empty folder for the current test.
std::filesystem::path fresh_folder();

}  // namespace shaker::test
