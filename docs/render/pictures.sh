#!/usr/bin/env bash
# Makes the pictures of docs/pictures: the examples' recordings at some time (s of the recording).
set -euo pipefail
cd "$(dirname "$0")"
recordings=$(mktemp -d)
made() { # example, time, further options
    local example=$1 time=$2
    shift 2
    (cd ../.. && cargo run --release --quiet -p hydroelastic-examples --example "$example" -- \
        --record "$recordings/$example.glb" --plot "$recordings/$example.svg")
    npm run --silent validate -- "$recordings/$example.glb"
    npm run --silent picture -- "$recordings/$example.glb" "../pictures/$example.png" --time "$time" "$@"
}
made throw_to_target 0.7 --width 1200 --height 640
made random_search 1.0 --width 480 --height 300
made bouncing_ball 1.08 --width 480 --height 300
made ball_on_incline 1.25 --width 480 --height 300
made billiards 0.6 --width 480 --height 300
made settle 0.0 --width 480 --height 300
made identify_material 1.0 --width 480 --height 300
made grasp 2.4 --width 480 --height 300
made stack 1.2 --width 480 --height 300
made tool_use 1.76 --width 480 --height 300
rm ../pictures/{identify_material,grasp,stack}.png
cp "$recordings"/{throw_to_target,identify_material,grasp,stack}.svg ../pictures/
# Of these, the plot alone.
for example in push_to_goal design_bumper; do
    (cd ../.. && cargo run --release --quiet -p hydroelastic-examples --example "$example" -- --plot "docs/pictures/$example.svg")
done
rm -r "$recordings"
