#pragma once
// Copies the output of a confined child to this process's own, made printable.
namespace shaker::sandbox {

/// Pipes for standard output and standard error of a child.
class Relay {
public:
    /// Throws DeviceError.
    Relay();
    ~Relay();
    Relay(const Relay&) = delete;
    Relay& operator=(const Relay&) = delete;

    /// In the child: its output goes into the pipes, its standard input is empty.
    void send();
    /// In this process: copies all output until the child has closed it. Output that nobody reads is dropped.
    void receive();

private:
    struct Pipe {
        int from = -1, to = -1;
    };
    Pipe out_, err_;
};

}  // namespace shaker::sandbox
