#include "cts-subset/harness/isolate.h"

#include <fmt/format.h>
#include <poll.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <cstring>
#include <fstream>

namespace pineda::cts {
namespace {

struct Verdict {
  std::string name;
  enum class Kind { kPass, kFail, kNotSupported } kind = Kind::kFail;
  std::string message;
};

// "pipeline.blend" of "pipeline.blend.R8_UNORM.op_add": the first word, and the second where it is not a case's.
std::string group_of(const std::string& name) {
  const size_t first = name.find('.'), second = name.find('.', first + 1);
  const std::string_view head = std::string_view(name).substr(0, first);
  const bool two_levels =
      head == "pipeline" || head == "glsl" || head == "api" || head == "renderpass" || head == "texture" || head == "wsi";
  return name.substr(0, two_levels ? second : first);
}

struct Child {
  pid_t pid = -1;
  int from = -1;  // its reports: a line each: P, N or F, the name, and after a tab the reason
};

Child start(const IsolationOptions& options, const std::string& list_path) {
  int report_pipe[2];
  if (pipe(report_pipe) != 0) return {};
  std::vector<std::string> arguments{options.program, "--child-list=" + list_path,
                                     fmt::format("--child-report={}", report_pipe[1])};
  arguments.insert(arguments.end(), options.arguments.begin(), options.arguments.end());
  std::vector<char*> argv;
  for (std::string& argument : arguments) argv.push_back(argument.data());
  argv.push_back(nullptr);
  std::fflush(nullptr);  // else the child would print what is buffered, too
  const pid_t pid = fork();
  if (pid == 0) {
    close(report_pipe[0]);
    if (!options.manifest.empty()) {
      setenv("VK_DRIVER_FILES", options.manifest.c_str(), 1);
      setenv("VK_ICD_FILENAMES", options.manifest.c_str(), 1);  // loaders before 1.3.207
    }
    if (!std::freopen("/dev/null", "w", stdout)) _exit(126);
    execv(options.program.c_str(), argv.data());
    _exit(127);
  }
  close(report_pipe[1]);
  return {pid, report_pipe[0]};
}

// Reads one line; nothing when the child is gone or silent for too long.
class LineReader {
 public:
  explicit LineReader(int fd) : fd_(fd) {}
  enum class Status { kLine, kEnd, kTimeout };
  Status next(std::string& line, std::chrono::seconds timeout) {
    for (;;) {
      if (const size_t end = pending_.find('\n'); end != std::string::npos) {
        line = pending_.substr(0, end);
        pending_.erase(0, end + 1);
        return Status::kLine;
      }
      pollfd ready{fd_, POLLIN, 0};
      const int count = poll(&ready, 1, static_cast<int>(std::chrono::milliseconds(timeout).count()));
      if (count == 0) return Status::kTimeout;
      char chunk[4096];
      const ssize_t size = read(fd_, chunk, sizeof(chunk));
      if (size <= 0) return Status::kEnd;
      pending_.append(chunk, static_cast<size_t>(size));
    }
  }

 private:
  int fd_;
  std::string pending_;
};

std::string describe_end(int status) {
  if (WIFSIGNALED(status))
    return fmt::format("the process ended by signal {} ({})", WTERMSIG(status), strsignal(WTERMSIG(status)));
  return fmt::format("the process ended with status {}", WEXITSTATUS(status));
}

// Runs cases[first..] in one child; gives the index behind the last case that has a verdict.
size_t run_child(const std::vector<std::string>& cases, size_t first, const IsolationOptions& options,
                 std::vector<Verdict>& verdicts) {
  const std::string list_path = fmt::format("/tmp/pineda_cts_{}.list", getpid());
  {
    std::ofstream list(list_path);
    for (size_t i = first; i < cases.size(); ++i) list << cases[i] << "\n";
  }
  const Child child = start(options, list_path);
  LineReader reader(child.from);
  size_t at = first;
  std::string line;
  LineReader::Status status;
  while ((status = reader.next(line, options.case_timeout)) == LineReader::Status::kLine) {
    Verdict verdict;
    verdict.kind = line[0] == 'P' ? Verdict::Kind::kPass : line[0] == 'N' ? Verdict::Kind::kNotSupported : Verdict::Kind::kFail;
    const size_t tab = line.find('\t');
    verdict.name = line.substr(1, tab == std::string::npos ? tab : tab - 1);
    if (tab != std::string::npos) verdict.message = line.substr(tab + 1);
    verdicts.push_back(std::move(verdict));
    ++at;
  }
  if (status == LineReader::Status::kTimeout) kill(child.pid, SIGKILL);
  close(child.from);
  int exit_status = 0;
  waitpid(child.pid, &exit_status, 0);
  unlink(list_path.c_str());
  if (at < cases.size()) {
    const std::string why = status == LineReader::Status::kTimeout
                                ? fmt::format("no verdict within {} s", options.case_timeout.count())
                                : describe_end(exit_status);
    verdicts.push_back({cases[at], Verdict::Kind::kFail, why});
    ++at;
  }
  return at;
}

std::string escape_xml(const std::string& text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '&':
        out += "&amp;";
        break;
      case '"':
        out += "&quot;";
        break;
      default:
        out += static_cast<unsigned char>(c) < 0x20 && c != '\t' ? ' ' : c;
    }
  }
  return out;
}

void write_junit(const std::string& path, const std::vector<Verdict>& verdicts, const Totals& totals) {
  std::ofstream out(path);
  out << fmt::format("<?xml version=\"1.0\"?>\n<testsuite name=\"pineda-cts\" tests=\"{}\" failures=\"{}\" skipped=\"{}\">\n",
                     verdicts.size(), totals.fail, totals.not_supported);
  for (const Verdict& verdict : verdicts) {
    const size_t dot = verdict.name.rfind('.');
    out << fmt::format("<testcase classname=\"{}\" name=\"{}\"", verdict.name.substr(0, dot), verdict.name.substr(dot + 1));
    if (verdict.kind == Verdict::Kind::kPass) {
      out << "/>\n";
    } else {
      const char* tag = verdict.kind == Verdict::Kind::kFail ? "failure" : "skipped";
      out << fmt::format("><{0} message=\"{1}\"/></testcase>\n", tag, escape_xml(verdict.message));
    }
  }
  out << "</testsuite>\n";
}

}  // namespace

Outcome run_isolated(const std::vector<std::string>& cases, const IsolationOptions& options) {
  std::vector<Verdict> verdicts;
  for (size_t next = 0; next < cases.size();) next = run_child(cases, next, options, verdicts);
  Outcome outcome;
  for (const Verdict& verdict : verdicts) {
    for (Totals* totals : {&outcome.all, &outcome.groups[group_of(verdict.name)]}) {
      totals->pass += verdict.kind == Verdict::Kind::kPass;
      totals->fail += verdict.kind == Verdict::Kind::kFail;
      totals->not_supported += verdict.kind == Verdict::Kind::kNotSupported;
    }
    if (verdict.kind == Verdict::Kind::kFail) std::printf("FAIL %s: %s\n", verdict.name.c_str(), verdict.message.c_str());
  }
  if (!options.junit_path.empty()) write_junit(options.junit_path, verdicts, outcome.all);
  return outcome;
}

}  // namespace pineda::cts
