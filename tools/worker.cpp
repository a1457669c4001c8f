#include "tools/worker.h"

#include <sys/prctl.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "tools/accuracy/suite_scene.h"
#include "tools/bench/rows.h"
#include "tools/child_process.h"
#include "tools/error.h"
#include "tools/errors/probe.h"
#include "tools/extreme/extreme.h"
#include "tools/scene_registry.h"
#include "tools/stopwatch.h"

namespace pineda::tools {
namespace {

using nlohmann::json;

class Worker {
 public:
  explicit Worker(FILE* replies) : replies_(replies) {}

  void handle(const std::string& line) {
    json reply;
    try {
      const json command = json::parse(line);
      reply = dispatch(command);
      reply["type"] = "result";
    } catch (const std::exception& error) {  // ToolError, JSON errors, std::bad_alloc, errors of the model importers
      reply = {{"type", "error"}, {"message", error.what()}};
    }
    send(reply);
  }

 private:
  json dispatch(const json& command) {
    const std::string name = command.at("command");
    if (name == "open") return open(command);
    if (!context_) fail("command '{}' before 'open'", name);
    if (name == "close") return close();
    if (name == "render") return render(command);
    if (name == "suite_render") return run_suite_scene(*context_, command);
    if (name == "extreme_run") return run_extreme_case(*context_, command);
    if (name == "row_begin") return begin_row(command);
    if (name == "row_run") return run_row(command);
    if (name == "row_end") return end_row();
    if (name == "errors_open") return open_errors(command);
    if (name == "errors_select") return select_function(command);
    if (name == "errors_run") return run_function(command);
    fail("unknown command '{}'", name);
  }

  json open(const json& command) {
    const Stopwatch watch;
    context_ = std::make_unique<VkContext>(command.value("validate", false) ? &validation_messages_ : nullptr);
    const double startup_ms = watch.elapsed_ms();
    const DeviceInfo info = context_->info();
    return {{"device", info.name},
            {"api_version", info.api_version},
            {"driver_version", info.driver_version},
            {"startup_ms", startup_ms}};
  }

  json close() {
    probe_.reset();
    context_.reset();  // validation reports what was not destroyed
    return {{"validation", validation_messages_}};
  }

  json render(const json& command) {
    const VkExtent2D extent{command.at("width"), command.at("height")};
    const size_t frame_count = command.value("frames", 1u);
    const double budget_ms = command.value("budget_ms", 1e9);
    progress("loading");
    const std::unique_ptr<Scene> scene = create_scene(command.at("scene"));
    progress("preparing");
    const Stopwatch prepare_watch;
    scene->prepare(*context_, extent);
    const VkCommandBuffer commands = context_->record([&](VkCommandBuffer buffer) { scene->record(buffer); });
    const double prepare_ms = prepare_watch.elapsed_ms();

    progress("first frame");
    std::vector<double> frames_ms;
    const Stopwatch total;
    do {
      const Stopwatch frame;
      context_->submit_and_wait(commands);
      frames_ms.push_back(frame.elapsed_ms());
      if (frames_ms.size() % 8 == 0) progress(fmt::format("frame {} of {}", frames_ms.size(), frame_count));
    } while (frames_ms.size() < frame_count && total.elapsed_ms() < budget_ms);

    if (!scene->picture().handle) fail("this scene draws no colours, only depth");
    const Image picture = read_back(*context_, scene->picture());
    context_->release(commands);
    if (command.contains("png")) save_png(command["png"], picture);
    return {{"hash", hash_of(picture)},
            {"prepare_ms", prepare_ms},
            {"first_frame_ms", frames_ms.front()},
            {"frames_ms", frames_ms},
            {"notes", scene->notes()}};
  }

  json begin_row(const json& command) {
    row_.reset();
    row_ = create_bench_row(command.at("row"), *context_, {command.at("width"), command.at("height")});
    row_->run_sample();
    const std::optional<MeanColour> mean_colour = row_->mean_colour();
    return {{"mean_colour", mean_colour ? json(*mean_colour) : json()}};
  }

  json run_row(const json& command) {
    if (!row_) fail("'row_run' before 'row_begin'");
    const double budget_ms = command.at("budget_ms");
    const size_t max_samples = command.at("max_samples");
    std::vector<double> samples_ms;
    const Stopwatch total;
    do {
      samples_ms.push_back(row_->run_sample());
    } while (samples_ms.size() < max_samples && total.elapsed_ms() < budget_ms);
    return {{"samples_ms", samples_ms}};
  }

  json end_row() {
    row_.reset();
    return json::object();
  }

  json open_errors(const json& command) {
    probe_ = std::make_unique<ErrorProbe>(*context_, command.at("path"), command.at("drivers"), command.at("driver"));
    return json::object();
  }

  json select_function(const json& command) {
    if (!probe_) fail("'errors_select' before 'errors_open'");
    probe_->select(command.at("function"), command.at("operands"));
    return json::object();
  }

  json run_function(const json& command) {
    if (!probe_) fail("'errors_run' before 'errors_open'");
    probe_->run(command.at("slot"));
    return json::object();
  }

  void progress(const std::string& text) { send({{"type", "progress"}, {"text", text}}); }

  void send(const json& reply) {
    // Messages from libraries and file names may be any bytes; a reply is always valid UTF-8.
    std::fprintf(replies_, "%s\n", reply.dump(-1, ' ', false, json::error_handler_t::replace).c_str());
    std::fflush(replies_);
  }

  FILE* replies_;
  std::vector<std::string> validation_messages_;  // outlives the context
  std::unique_ptr<VkContext> context_;
  std::unique_ptr<BenchRow> row_;  // these die before the context
  std::unique_ptr<ErrorProbe> probe_;
};

}  // namespace

int run_worker() {
  prctl(PR_SET_PDEATHSIG, SIGKILL);  // never outlives the parent
  FILE* const commands = fdopen(kCommandFd, "r");
  FILE* const replies = fdopen(kReplyFd, "w");
  if (!commands || !replies) {
    std::fputs("pineda worker: is started by `pineda compare` and `pineda bench`, not by hand\n", stderr);
    return 2;
  }
  Worker worker(replies);
  char* line = nullptr;
  size_t capacity = 0;
  for (ssize_t length; (length = getline(&line, &capacity, commands)) >= 0;) {
    worker.handle(std::string(line, static_cast<size_t>(length)));
  }
  std::free(line);
  return 0;
}

}  // namespace pineda::tools
