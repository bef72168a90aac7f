//! Evaluation of `Anim_Ctrl` keys.
