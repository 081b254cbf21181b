import sys
sys.argv=['w','uc4','7.5,8,7,9','0,1,2,3','1','0','60']
exec(open('wip/write.py').read())
import cProfile,pstats,random
lv=[l for l in s2.leaves if l.node.name in ("UNBALANCED","NO_LENGTH") and not l.cell.placed]
lv=random.Random(2).sample(lv,240)
import time
t=time.process_time()
for l in lv: s2.check(l)
print('ms',(time.process_time()-t)/len(lv)*1e3)
cProfile.run("for l in lv: s2.check(l)",'/tmp/p/prof'); pstats.Stats('/tmp/p/prof').sort_stats('cumtime').print_stats(40)
