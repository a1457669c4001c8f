#include "tools/child_process.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <map>
#include <utility>

#include "tools/error.h"

namespace pineda::tools {
namespace {

using Clock = std::chrono::steady_clock;
constexpr std::chrono::seconds kGracePeriod{5};  // for a child to end after its command pipe is closed
constexpr size_t kOutputTailBytes = 2000;

struct Pipe {
  int read_fd = -1, write_fd = -1;
};

Pipe make_pipe() {
  int fds[2];
  if (pipe2(fds, O_CLOEXEC) != 0) fail("pipe2: {}", std::strerror(errno));
  return {fds[0], fds[1]};
}

std::vector<std::string> merged_environment(const Environment& changes) {
  std::map<std::string, std::string> merged;
  for (char** entry = environ; *entry; ++entry) {
    const std::string text = *entry;
    const size_t equals = text.find('=');
    if (equals != std::string::npos) merged[text.substr(0, equals)] = text.substr(equals + 1);
  }
  for (const auto& [name, value] : changes) merged[name] = value;
  std::vector<std::string> result;
  for (const auto& [name, value] : merged) result.push_back(name + "=" + value);
  return result;
}

std::vector<char*> to_pointers(std::vector<std::string>& strings) {
  std::vector<char*> pointers;
  for (std::string& string : strings) pointers.push_back(string.data());
  pointers.push_back(nullptr);
  return pointers;
}

}  // namespace

ChildProcess::ChildProcess(const std::vector<std::string>& arguments, const Environment& environment) {
  signal(SIGPIPE, SIG_IGN);  // a dead child shows as a failed write
  const Pipe commands = make_pipe(), replies = make_pipe();
  output_fd_ = memfd_create("pineda-child-output", MFD_CLOEXEC);
  // Out of the way of the numbers that the child gets, so that no dup2 below overwrites a source of the next one.
  const int child_command = fcntl(commands.read_fd, F_DUPFD_CLOEXEC, 10),
            child_reply = fcntl(replies.write_fd, F_DUPFD_CLOEXEC, 10);
  const int child_output = fcntl(output_fd_, F_DUPFD_CLOEXEC, 10);
  close(commands.read_fd);
  close(replies.write_fd);
  command_fd_ = commands.write_fd;
  reply_fd_ = replies.read_fd;

  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_adddup2(&actions, child_output, STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&actions, child_output, STDERR_FILENO);
  posix_spawn_file_actions_adddup2(&actions, child_command, kCommandFd);
  posix_spawn_file_actions_adddup2(&actions, child_reply, kReplyFd);
  std::vector<std::string> argument_storage = arguments, environment_storage = merged_environment(environment);
  std::vector<char*> argv = to_pointers(argument_storage), envp = to_pointers(environment_storage);
  const int error = posix_spawn(&pid_, argv[0], &actions, nullptr, argv.data(), envp.data());
  posix_spawn_file_actions_destroy(&actions);
  for (const int fd : {child_command, child_reply, child_output}) close(fd);
  if (error != 0) {
    for (const int fd : {command_fd_, reply_fd_, output_fd_}) close(fd);
    fail("{}: cannot be started: {}", arguments[0], std::strerror(error));
  }
}

ChildProcess::~ChildProcess() {
  finish();
  close(reply_fd_);
  close(output_fd_);
}

std::optional<std::string> ChildProcess::finish() {
  if (command_fd_ >= 0) close(std::exchange(command_fd_, -1));  // the child's loop ends at the end of its input
  const auto deadline = Clock::now() + kGracePeriod;
  while (!status_ && Clock::now() < deadline) {
    int status = 0;
    if (waitpid(pid_, &status, WNOHANG) != 0) status_ = status;
    if (!status_) usleep(500);
  }
  if (!status_) {
    kill();
    wait_and_describe();
    return "did not end by itself";
  }
  if (*status_ == 0) return std::nullopt;
  return wait_and_describe();
}

bool ChildProcess::write_line(const std::string& line) {
  const std::string text = line + "\n";
  for (size_t written = 0; written < text.size();) {
    const ssize_t count = write(command_fd_, text.data() + written, text.size() - written);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return false;
    written += static_cast<size_t>(count);
  }
  return true;
}

ChildProcess::Status ChildProcess::read_line(std::string& line, std::chrono::milliseconds timeout) {
  const auto deadline = Clock::now() + timeout;
  for (;;) {
    if (const size_t end = pending_.find('\n'); end != std::string::npos) {
      line = pending_.substr(0, end);
      pending_.erase(0, end + 1);
      return Status::kLine;
    }
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(deadline - Clock::now());
    if (left.count() <= 0) return Status::kTimeout;
    pollfd descriptor{.fd = reply_fd_, .events = POLLIN};
    const int ready = poll(&descriptor, 1, static_cast<int>(std::min<int64_t>(left.count(), 1 << 30)));
    if (ready < 0 && errno != EINTR) return Status::kClosed;
    if (ready <= 0) continue;
    char buffer[4096];
    const ssize_t count = read(reply_fd_, buffer, sizeof buffer);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return Status::kClosed;
    pending_.append(buffer, static_cast<size_t>(count));
  }
}

void ChildProcess::kill() {
  if (!status_) ::kill(pid_, SIGKILL);
}

std::string ChildProcess::wait_and_describe() {
  if (!status_) {
    int status = 0;
    while (waitpid(pid_, &status, 0) < 0 && errno == EINTR) {
    }
    status_ = status;
  }
  if (WIFSIGNALED(*status_)) {
    const int number = WTERMSIG(*status_);
    return fmt::format("was killed by signal {} ({})", number, strsignal(number));
  }
  return fmt::format("ended with exit status {}", WEXITSTATUS(*status_));
}

std::string ChildProcess::last_output() const {
  const off_t size = lseek(output_fd_, 0, SEEK_END);
  if (size <= 0) return {};
  const off_t begin = std::max<off_t>(0, size - static_cast<off_t>(kOutputTailBytes));
  std::string text(static_cast<size_t>(size - begin), '\0');
  const ssize_t count = pread(output_fd_, text.data(), text.size(), begin);
  text.resize(count > 0 ? static_cast<size_t>(count) : 0);
  while (!text.empty() && text.back() == '\n') text.pop_back();
  return text;
}

}  // namespace pineda::tools
