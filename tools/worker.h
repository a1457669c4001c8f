// The child's side: `pineda worker` reads commands, one JSON object a line, and answers each with any number of {"type":
// "progress"} lines and one {"type": "result"} or {"type": "error", "message"}.
//
//   {"command": "open", "validate": bool}                      -> device, api_version, driver_version, startup_ms
//   {"command": "render", "scene", "width", "height", "frames", "budget_ms", "png"}
//                                                              -> hash, prepare_ms, first_frame_ms, frames_ms[], notes[]
//   {"command": "suite_render", ...}                          -> accuracy/suite_scene.h
//   {"command": "extreme_run", ...}                           -> extreme/extreme.h
//   {"command": "row_begin", "row", "width", "height"}         -> mean_colour; the row is prepared and has run once
//   {"command": "row_run", "budget_ms", "max_samples"}         -> samples_ms[]
//   {"command": "row_end"}
//   {"command": "close"}                                       -> validation[]: all that the validation layer said
#pragma once

namespace pineda::tools {

int run_worker();  // until the end of the input

}  // namespace pineda::tools
