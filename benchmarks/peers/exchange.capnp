# For capnp. Its lists carry a pointer: members carry the same without one.
@0xb3d6a1c0f7e94a15;
struct Sample {
  stamp @0 :Float64;
  a @1 :Float64; b @2 :Float64; c @3 :Float64; d @4 :Float64; e @5 :Float64; f @6 :Float64; g @7 :Float64;
}
interface Exchange {
  echo @0 (given :Sample) -> (answer :Sample);
}
interface Camera {
  next @0 () -> (image :Data);
}
